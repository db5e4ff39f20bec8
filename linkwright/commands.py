"""One command line of the compiler's commands, the runtime's, and those of `linkwright` alone."""

from copy import copy
from pathlib import Path
from typing import Annotated, Any

import typer

from codegen import __version__
from codegen.cli import ModelArgument, SceneOption, progress_shown
from codegen.cli import app as compiler
from linkwright.command_panels_and_examples import KINDS, PANELS, panel_and_line
from linkwright.help_and_usage_errors import Command, Commands
from linkwright.parameter_presentation import presented
from linkwright.shell_completion import template_kinds
from runtime.cli.app import app as analyses
from runtime.cli.common import (
    Generated,
    Json,
    Scene,
    Values,
    error_head,
    exit_on_error,
    option,
    print_json,
    start_values,
    write_line,
)

ABOUT = "A compiler for planar mechanisms: declare a machine, compile it, analyse it."
own = typer.Typer()
app = typer.Typer(
    name="linkwright",
    cls=Commands,
    help=ABOUT,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


@own.command()
def new(
    name: Annotated[
        str, typer.Argument(help="Name of the model and its file NAME.py.", metavar="NAME")
    ],
    kind: Annotated[
        str,
        typer.Option(
            help=f"Machine to start from: {', '.join(KINDS)}.",
            metavar="KIND",
            autocompletion=template_kinds,
        ),
    ] = "four-bar",
) -> None:
    """Write a commented model to start from into the working folder; it overwrites nothing."""
    from linkwright.new_model import first_commands, write_model

    with exit_on_error(as_json=False):
        path = write_model(name, kind)
    typer.echo(f"{path}: a {kind.replace('_', '-')} to start from. Next:")
    for line in first_commands(path, kind):
        typer.echo(f"  {line}")


@own.command("list")
def list_models(
    folder: Annotated[
        Path | None,
        typer.Argument(
            help="A folder of model files; without it this folder, its models/ and the library.",
            metavar="FOLDER",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """List models and their scenes, a line each from their docstrings."""
    from linkwright.model_listing import facts, found_models, show

    with exit_on_error(as_json):
        found = found_models(folder)
    if as_json:
        print_json(facts(found))
    else:
        show(found)


@own.command()
def check(
    model: ModelArgument,
    scene: SceneOption = None,
    settings: Values = None,
    as_json: Json = False,
) -> None:
    """Check a declaration: all problems at once, or freedoms, redundant constraints, assembly.

    Nothing is compiled. Exit status 2 where something is wrong.
    """
    from codegen.declaration_report import check_declaration
    from linkwright.declaration_display import show

    with exit_on_error(as_json):
        parameters = start_values(settings, None)["parameters"]
        with progress_shown() as progress:
            report = check_declaration(model, scene, settings=parameters, progress=progress)
    for problem in report.problems:
        write_line(f"{error_head()} {problem}")
    if as_json:
        print_json(report.facts())
    else:
        show(report, model)
    if report.problems:
        raise typer.Exit(2)


@own.command()
def draw(
    model: ModelArgument,
    out: Annotated[Path, option("The picture to write: .png, .svg or .pdf.")],
    scene: Scene = None,
    t: Annotated[
        float | None,
        option("Instant in s at which the machine is assembled; unless given, its start is drawn, "
               "and nothing is compiled."),
    ] = None,
    settings: Values = None,
    generated: Generated = None,
    dimensions: Annotated[
        bool, option("Also distances between the points of a body, m.", "--dimensions")
    ] = False,
    forces: Annotated[bool, option("Also the applied forces, to scale.", "--forces")] = False,
    frames: Annotated[bool, option("Also frames and centres of mass.", "--frames")] = False,
    names: Annotated[bool, option("Names of bodies and joints, or none.")] = True,
    guesses: Annotated[
        bool, option("Bodies at their guesses, and how far each joint is open.", "--guesses")
    ] = False,
    as_json: Json = False,
) -> None:  # fmt: skip
    """Draw a machine as it is declared, at its start or at an instant, into a file."""
    from linkwright.mechanism_drawing import save_drawing

    with exit_on_error(as_json), progress_shown() as progress:
        saved = save_drawing(
            model, scene, t, start_values(settings, None)["parameters"], out, progress,
            generated=generated, dimensions=dimensions, forces=forces, frames=frames, names=names,
            assembled=not guesses,
        )  # fmt: skip
    write_line(f"Saved: {saved}")
    if as_json:
        print_json({"ok": True, "saved": str(saved)})


@own.command()
def precompile(
    methods: Annotated[
        list[str] | None, typer.Argument(help="Integration methods; all unless given.")
    ] = None,
) -> None:
    """Compile the runtime ahead of the first run, in several processes: a line for each part."""
    from runtime.precompile import precompile as compile_ahead

    with exit_on_error(as_json=False):
        compile_ahead(*(methods or ()), told=typer.echo)


def _name(command: Any) -> str:
    return str(command.name or command.callback.__name__.replace("_", "-"))


def _gather() -> None:
    """Register all commands, in the order of the panels."""
    order = [name for names in PANELS.values() for name in names]
    every = [c for part in (own, compiler, analyses) for c in part.registered_commands]
    every.sort(key=lambda c: order.index(_name(c)) if _name(c) in order else len(order))
    for given in every:
        command = copy(given)
        assert command.callback is not None
        command.cls = Command
        command.rich_help_panel, command.short_help = panel_and_line(_name(given))
        command.callback = presented(command.callback)
        app.registered_commands.append(command)


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
    """A compiler for planar mechanisms: declare a machine, compile it, analyse it."""


_gather()
