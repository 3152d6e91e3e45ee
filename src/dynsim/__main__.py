"""`python -m dynsim` is the command `dynsim`."""

from dynsim.cli.commands import main

if __name__ == "__main__":
    main()
