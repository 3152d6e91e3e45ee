"""`python -m blockstat` is the command `blockstat`."""

from blockstat.cli.commands import main

if __name__ == "__main__":
    main()
