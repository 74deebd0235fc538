"""The command ``makadam``, as ``python -m makadam`` and as the script that the package installs."""

from __future__ import annotations

import sys

from ._core import _command

__all__ = ["main"]


def main() -> int:
    """Runs the command on the arguments of the process, and returns its exit code."""
    return _command(["makadam", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
