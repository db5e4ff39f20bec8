"""The command `linkwright`: all commands of `python -m codegen` and of `python -m runtime`.

Its folder of programs comes first on the path of modules, and not the working folder, so that no
file of the user's stands for a module of the library. The working folder comes last, since model
files may import what lies there.
"""

import os
import sys


def main() -> None:
    """Entry point."""
    from codegen.termination_signals import finish, take_over

    take_over()  # before anything that takes time
    here = os.getcwd()  # noqa: PTH109 (no import)
    if here not in sys.path and not sys.flags.safe_path:
        sys.path.append(here)
    from linkwright.commands import app
    from runtime.cli.common import show_warnings_as_notes

    show_warnings_as_notes()
    try:
        app(prog_name="linkwright")
    finally:
        finish()
