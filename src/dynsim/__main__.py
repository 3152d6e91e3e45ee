"""The command `dynsim`, also as `python -m dynsim`. SIGINT ends it without a stack trace, imports included."""

from blockstat.system.process import end_when_interrupted


def main() -> None:
    """Run the command `dynsim`; this is the entry point of the console script."""
    end_when_interrupted("dynsim")
    from dynsim.cli.commands import main as command

    command()


if __name__ == "__main__":
    main()
