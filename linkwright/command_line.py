"""The program: `linkwright`, `python -m linkwright`, `python -m codegen`, `python -m runtime`.

The working folder comes last on the path of modules, so that no file of the user's stands for a
module of the library; it is there because model files may import what lies in it.
"""

import os
import sys
from io import TextIOWrapper


def main(name: str = "linkwright") -> None:
    """Run the command that the arguments of the process name; the process ends with its status."""
    from codegen.termination_signals import finish, take_over

    take_over()  # before anything that takes time
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # of a locale that may lack a letter of ours
            stream.reconfigure(errors="backslashreplace")
    here = os.getcwd()  # noqa: PTH109 (no import)
    if here not in sys.path and not sys.flags.safe_path:
        sys.path.append(here)
    import warnings

    from linkwright.cli.application import app

    warnings.formatwarning = lambda message, *_, **__: f"note: {message}\n"
    try:
        app(prog_name=name)
    finally:
        finish()
