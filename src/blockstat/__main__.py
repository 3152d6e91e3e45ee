"""The command `blockstat`, also as `python -m blockstat`. SIGINT ends it without a stack trace, imports included."""

from blockstat.system.process import end_when_interrupted


def main() -> None:
    """Run the command `blockstat`; this is the entry point of the console script."""
    end_when_interrupted("blockstat")
    from blockstat.cli.commands import main as command

    command()


if __name__ == "__main__":
    main()
