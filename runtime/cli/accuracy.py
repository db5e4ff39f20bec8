"""`python -m runtime accuracy`: the work-precision diagram of a scene."""

from pathlib import Path
from typing import Annotated

import typer

from runtime.cli.common import (
    Guess,
    Json,
    Model,
    MotionStart,
    OptionalTEnd,
    Parameters,
    Scene,
    exit_on_error,
    print_json,
    start_values,
    write_line,
)

Quantities = Annotated[
    list[str] | None,
    typer.Option(
        help="A series that is compared, such as crank.phi; again for more. Unless given, the "
        "coordinates that the scene starts from, and their velocities. a.x|b.x is whichever of "
        "them a scene has."
    ),
]


def accuracy(
    model: Model,
    scene: Scene = None,
    quantity: Quantities = None,
    t_end: OptionalTEnd = None,
    t_start: MotionStart = 0.0,
    method: Annotated[
        list[str] | None, typer.Option(help="Integration method; again for more. All unless given.")
    ] = None,
    formulation: Annotated[
        list[str] | None, typer.Option(help="cartesian or reduced; both unless given.")
    ] = None,
    reference: Annotated[
        Path | None,
        typer.Option(help="A .csv file with columns t, in s, and the quantities: the reference."),
    ] = None,
    points: Annotated[int, typer.Option(help="Instants at which runs are compared.")] = 200,
    modelling: Annotated[
        bool, typer.Option(help="Run the other fidelities of rods, contacts and frictions as well.")
    ] = True,
    beside: Annotated[
        list[str] | None,
        typer.Option(help="A further scene that models the same machine; again for more."),
    ] = None,
    building: Annotated[
        bool | None,
        typer.Option(help="Build the scene anew and time each stage; not with --quick."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Four tolerances in place of seventeen, few repeats.")
    ] = False,
    limit: Annotated[float, typer.Option(help="Seconds that a run may take.")] = 10.0,
    settings: Parameters = None,
    guess: Guess = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the picture and the runs as JSON lines.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Work-precision: digits against time, by method, formulation and modelling choice."""
    from runtime.integrate.method import METHODS
    from runtime.studies.work_precision import accuracy as work_precision
    from runtime.studies.work_precision.picture import check_folder, save
    from runtime.studies.work_precision.settings_grid import FORMULATIONS

    with exit_on_error(as_json):
        if out is not None:
            check_folder(out)
        diagram = work_precision(
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
            progress=write_line,
            **start_values(settings, guess),
        )
        if out is not None:
            for path in save(diagram, out):
                write_line(f"Saved: {path}")
    if as_json:
        print_json({"ok": True, **diagram.facts()})
        return
    from runtime.show.terminal_table import show
    from runtime.studies.work_precision.interpretation import sentences
    from runtime.studies.work_precision.terminal_table import score, work

    show((score(diagram), work(diagram)), sentences(diagram))
