"""Commands about declarations: new, list, elements, check, draw."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from codegen.errors import InputError
from linkwright.cli import completion
from linkwright.cli.compilation import refuse_stale
from linkwright.cli.options import (
    AnyScene,
    Check,
    Generated,
    Json,
    ModelFile,
    Scene,
    Values,
    examples,
    output,
    parameters,
    picture,
    time,
)
from linkwright.cli.output import (
    console,
    escaped,
    print_json,
    progress_shown,
    write_error,
    write_line,
)

app = typer.Typer()
command = partial(app.command, rich_help_panel="Declare")
KINDS = completion.MODELS_TO_START_FROM


@command(epilog=examples("linkwright new four_bar", "linkwright new press --kind slider-crank"))
def new(
    name: Annotated[
        str, typer.Argument(help="Name of the model and its file NAME.py.", metavar="NAME")
    ],
    kind: Annotated[
        str,
        typer.Option(help=f"Machine to start from: {', '.join(KINDS)}.", metavar="KIND",
                     autocompletion=completion.models_to_start_from),
    ] = "four-bar",
) -> None:  # fmt: skip
    """Write a commented model to start from into the working folder; it overwrites nothing."""
    from linkwright.cli.new_model import first_commands, write_model

    path = write_model(name, kind)
    typer.echo(f"{path}: a {kind.replace('_', '-')} to start from. Next:")
    for line in first_commands(path, kind):
        typer.echo(f"  {line}")


@command("list", epilog=examples("linkwright list", "linkwright list ."))
def list_models(
    folder: Annotated[
        Path | None,
        typer.Argument(
            help="A folder of model files; without it this folder, its models/ and the library.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """List models and their scenes, a line each from their docstrings."""
    from linkwright.cli.model_listing import facts, found_models, show

    found = found_models(folder)
    if as_json:
        print_json(facts(found))
    else:
        show(found)


@command(
    epilog=examples(
        "linkwright elements",
        "linkwright elements revolute",
        "linkwright elements one-way-clutch",
    )
)
def elements(
    kind: Annotated[
        list[str] | None,
        typer.Argument(
            help="A kind of element, with spaces, hyphens or underscores between its words; "
            "without it, all are listed.",
            metavar="KIND",
            autocompletion=completion.kinds,
        ),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(help="A model file with your own elements.", metavar="MODEL",
                     autocompletion=completion.models),
    ] = None,
    out: Annotated[
        Path | None,
        output("Folder to write the pages into, as docs/elements."),
    ] = None,
    check: Check = False,
) -> None:  # fmt: skip
    """List joints, drivers and forces, show the page of one, or write all pages as files."""
    from codegen.reading.model_file import read_model
    from codegen.reference.pages import chosen_kinds, find_kind, page, write

    declared = read_model(model).model if model else None
    only = find_kind(" ".join(kind)) if kind else None
    folder = out or (Path("docs/elements") if check else None)
    if folder is not None:
        written = write(folder, declared, only, check=check)
        if check:
            reason = "is missing, out of date, or of no kind"
            refuse_stale(written.stale, reason, f"elements --out {folder}")
        changed = len(written.stale)
        console().print(
            f"{len(written.paths)} pages in {escaped(folder)}, {changed} of them written"
        )
    elif only is not None:
        typer.echo(page(only, declared), nl=False)
    else:
        from rich.console import Console
        from rich.table import Table

        from codegen.explain.terminal_table import PAPER

        table = Table("kind", "role", "summary")
        for name, registered in chosen_kinds(declared).items():
            table.add_row(name, registered.role, escaped(registered.summary))
        Console(width=PAPER, highlight=False).print(table)


@command(
    epilog=examples(
        "linkwright check four_bar.py",
        "linkwright check four_bar.py --scene driven --json",
    )
)
def check(
    model: ModelFile, scene: AnyScene = None, settings: Values = None, as_json: Json = False
) -> None:
    """Find everything that is wrong with a declaration.

    If nothing is: freedoms, redundant constraints, assembly. Nothing is compiled. Exit status 2
    where something is wrong.
    """
    from codegen.explain.declaration_report import check_declaration
    from linkwright.cli.declaration_display import show

    values = parameters(settings)
    with progress_shown() as progress:
        report = check_declaration(model, scene, settings=values, progress=progress)
    for problem in report.problems:
        write_error(problem)
    if as_json:
        print_json(report.facts())
    else:
        show(report, model)
    if report.problems:
        raise typer.Exit(2)


@command(
    epilog=examples(
        "linkwright draw four_bar.py --out four_bar.png",
        "linkwright draw four_bar.py --scene driven --t 0.25 --forces --out quarter.svg",
    )
)
def draw(
    model: ModelFile,
    out: Annotated[Path, output("The picture to write: .png, .svg or .pdf.")],
    scene: Scene = None,
    t: Annotated[
        float | None,
        time("Instant in s at which the machine is assembled; unless given, its start is drawn, "
             "and nothing is compiled."),
    ] = None,
    settings: Values = None,
    generated: Generated = None,
    dimensions: Annotated[
        bool, picture("Also distances between the points of a body, m.", "--dimensions")
    ] = False,
    forces: Annotated[bool, picture("Also the applied forces, to scale.", "--forces")] = False,
    frames: Annotated[bool, picture("Also frames and centres of mass.", "--frames")] = False,
    names: Annotated[bool, picture("Names of bodies and joints, or none.")] = True,
    guesses: Annotated[
        bool, picture("Bodies at their guesses, and how far each joint is open.", "--guesses")
    ] = False,
    as_json: Json = False,
) -> None:  # fmt: skip
    """Draw a machine as it is declared, at its start or at an instant, into a file."""
    from codegen.presentation import check_picture, save_picture

    check_picture(out)
    if guesses and t is not None:
        raise InputError("--guesses with --t: at an instant joints are closed; leave one out.")
    wanted: dict[str, Any] = {
        "parameters": parameters(settings), "dimensions": dimensions, "forces": forces,
        "frames": frames, "names": names,
    }  # fmt: skip
    with progress_shown("drawing"):
        if t is None:
            from codegen.reading.model_file import read_model

            figure = read_model(model).model.draw(scene, assembled=not guesses, **wanted)
        else:
            from runtime.machine_loading import load

            figure = load(model, scene, generated=generated).draw(t, **wanted)
        save_picture(figure, out)
    write_line(f"Saved: {out}")
    if as_json:
        print_json({"ok": True, "saved": str(out)})
