"""One command line of the compiler's commands and the runtime's."""

from copy import copy
from typing import Annotated

import typer

from codegen import __version__
from codegen.cli import app as compiler
from runtime.cli.app import app as analyses
from runtime.cli.common import exit_on_error

app = typer.Typer(
    name="linkwright",
    help="A compiler for planar mechanisms: build a declared machine, and analyse it.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _add(commands: typer.Typer, panel: str) -> None:
    for command in map(copy, commands.registered_commands):
        command.rich_help_panel = panel
        app.registered_commands.append(command)


_add(compiler, "Compile")


@app.command(rich_help_panel="Compile")
def precompile(
    methods: Annotated[
        list[str] | None, typer.Argument(help="Integration methods; all unless given.")
    ] = None,
) -> None:
    """Compile the runtime ahead of the first run, in several processes: a line for each part."""
    from runtime.precompile import precompile as compile_ahead

    with exit_on_error(as_json=False):
        compile_ahead(*(methods or ()), told=typer.echo)


_add(analyses, "Analyse")


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
    """A compiler for planar mechanisms: build a declared machine, and analyse it."""
