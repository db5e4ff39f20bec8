"""The application: every command, and errors of a command line in the words of all other errors.

Exit status: 0 done, 1 the run failed (the message says at which t, and what was saved), 2 the
user's input is wrong, 128 + n stopped by signal n: 129 SIGHUP, 130 SIGINT, 143 SIGTERM. With
--json, stdout holds one object.
"""

import sys
from collections.abc import Iterable
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from codegen import __version__
from codegen.errors import InputError, LinkwrightError
from codegen.readers.values import one_line
from linkwright.cli import analyses, compilation, declarations, studies
from linkwright.cli.options import examples
from linkwright.cli.output import print_json, write_error, write_line

_LONGEST = 2000  # layout: characters of a sentence


class Commands(TyperGroup):
    """The group of all commands, which reports whatever ends one of them."""

    def main(self, *words: Any, **settings: Any) -> None:
        """Run a command and end the process with its status."""
        context = None
        problems: Iterable[str]
        try:
            done = super().main(*words, **settings | {"standalone_mode": False})
            sys.exit(done if isinstance(done, int) else 0)
        except typer.TyperException as error:
            text = error.format_message()  # nothing where the help has been printed
            problems, status = [one_line(text, _LONGEST)] if text else [], error.exit_code
            context = getattr(error, "ctx", None) if text else None
        except InputError as error:
            problems, status = error.problems, 2
        except (LinkwrightError, OSError) as error:
            problems, status = [str(error)], 1
        except typer.Abort:
            problems, status = ["stopped before the end."], 1
        for problem in problems:
            write_error(problem)
        if context is not None:
            for line in (context.command.epilog or "").split("\n\n")[1:2]:
                write_line(f"  Example: {line}")
            write_line(f"  All options: {context.command_path} --help")
        given = settings.get("args")
        if "--json" in (sys.argv[1:] if given is None else given):
            print_json({"ok": False, "status": status, "problems": list(problems)})
        sys.exit(status)


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    epilog=examples(
        "linkwright new four_bar",
        "linkwright check four_bar.py",
        "linkwright draw four_bar.py --out four_bar.png",
        "linkwright simulate four_bar.py --t-end 5 --out run.nc",
        "linkwright report four_bar.py --t-end 5 --out run.html",
    ),
)
for _part in (declarations, compilation, analyses, studies):
    app.add_typer(_part.app)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"linkwright {__version__}")
        raise typer.Exit


@app.callback()
def about(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    """A compiler for mechanisms in the plane and in space: declare, compile, analyse a machine."""
