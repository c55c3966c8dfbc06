"""The command ``uchain``."""

import sys

from ._uchain import command as _command


def main() -> int:
    """Carry out the command line; return the exit status."""
    return _command(["uchain", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
