"""`python -m runtime accuracy`: what the accuracy of a scene's motion costs in time."""

from pathlib import Path
from typing import Annotated

import typer

from codegen.errors import InputError, LinkwrightError
from runtime.cli.common import pairs, print_json, refuse, say


def accuracy(
    model: Annotated[str, typer.Argument(help="Path of a model file, or a name: models/NAME.py.")],
    scene: Annotated[
        str | None, typer.Option(help="Scene of the model; the first unless given.")
    ] = None,
    quantity: Annotated[
        list[str] | None,
        typer.Option(
            help="A series that is compared, such as crank.phi; again for more. Unless given, "
            "the coordinates that the scene starts from, and their velocities. a.x|b.x is the one "
            "that a scene has."
        ),
    ] = None,
    t_end: Annotated[float | None, typer.Option("--t-end", help="Last instant in s.")] = None,
    t_start: Annotated[float, typer.Option("--t-start", help="First instant in s.")] = 0.0,
    method: Annotated[
        list[str] | None, typer.Option(help="Integration method; again for more. All unless given.")
    ] = None,
    formulation: Annotated[
        list[str] | None, typer.Option(help="cartesian or reduced; both unless given.")
    ] = None,
    reference: Annotated[
        Path | None,
        typer.Option(help="A .csv file with columns t, in s, and the quantities: the truth."),
    ] = None,
    points: Annotated[int, typer.Option(help="Instants at which runs are compared.")] = 200,
    modelling: Annotated[
        bool, typer.Option(help="Run also what else stands for a rod, a contact, a friction.")
    ] = True,
    beside: Annotated[
        list[str] | None,
        typer.Option(help="A further scene that stands for the same machine; again for more."),
    ] = None,
    building: Annotated[
        bool | None,
        typer.Option(help="Build the scene anew, to tell what that takes; not with --quick."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Four tolerances in place of seventeen, few repeats.")
    ] = False,
    limit: Annotated[float, typer.Option(help="Seconds that a run may take.")] = 10.0,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="NAME=VALUE: a parameter, in its declared unit."),
    ] = None,
    guess: Annotated[
        list[str] | None, typer.Option("--guess", help="NAME=VALUE: a start value, in SI units.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the picture and the runs as JSON lines.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """What accuracy costs: digits against time, by method, formulation and modelling choice."""
    from runtime.integrate.method import METHODS
    from runtime.studies.work_precision import accuracy as study
    from runtime.studies.work_precision.picture import check_folder, save
    from runtime.studies.work_precision.settings_grid import FORMULATIONS

    try:
        if out is not None:
            check_folder(out)
        told = study(
            model,
            scene,
            quantities=tuple(quantity or ()),
            t_end=t_end,
            t_start=t_start,
            methods=tuple(method or METHODS),
            formulations=tuple(formulation or FORMULATIONS),
            points=points,
            reference=reference,
            modelling=modelling,
            beside=tuple(beside or ()),
            building=building,
            quick=quick,
            limit=limit,
            parameters=pairs(settings, "--set"),
            guess=pairs(guess, "--guess"),
            progress=say,
        )
        if out is not None:
            for path in save(told, out):
                say(f"Saved: {path}")
    except InputError as problem:
        refuse(problem.problems, 2, as_json)
    except (LinkwrightError, OSError) as problem:
        refuse((str(problem),), 1, as_json)
    if as_json:
        print_json({"ok": True, **told.facts()})
        return
    from runtime.show.terminal_table import show
    from runtime.studies.work_precision.interpretation import sentences
    from runtime.studies.work_precision.terminal_table import score, work

    show((score(told), work(told)), sentences(told))
