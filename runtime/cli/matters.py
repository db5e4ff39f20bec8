"""`python -m runtime matters`: which effects of a scene a question calls for."""

from pathlib import Path
from typing import Annotated

import typer

from codegen.errors import InputError, LinkwrightError
from runtime.cli.common import pairs, print_json, refuse, say


def matters(
    model: Annotated[str, typer.Argument(help="Path of a model file, or a name: models/NAME.py.")],
    quantity: Annotated[
        str,
        typer.Option(
            help="A coordinate, velocity, a(coordinate), reaction, energy or power at the end; "
            "max:, min:, peak:, range:, mean:, rate: or period: of one; event:EFFECT, "
            "count:EFFECT."
        ),
    ],
    scene: Annotated[
        str | None, typer.Option(help="Scene of the model; the first unless given.")
    ] = None,
    t_end: Annotated[
        float | None, typer.Option("--t-end", help="Last instant in s; no equilibrium needs one.")
    ] = None,
    t_start: Annotated[float, typer.Option("--t-start", help="First instant in s.")] = 0.0,
    error: Annotated[
        float | None,
        typer.Option(help="Relative change that is permitted; proposes the cheapest scene."),
    ] = None,
    analysis: Annotated[
        str | None,
        typer.Option(help="simulate, kinematics, inverse or equilibrium; what the scene is for."),
    ] = None,
    fidelities: Annotated[
        bool, typer.Option(help="Try also what else stands for a rod, a contact, a friction.")
    ] = True,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="NAME=VALUE: a parameter, in its declared unit."),
    ] = None,
    guess: Annotated[
        list[str] | None, typer.Option("--guess", help="NAME=VALUE: a start value, in SI units.")
    ] = None,
    method: Annotated[str, typer.Option(help="Integration method, as in simulate.")] = "dop853",
    rtol: Annotated[
        float, typer.Option(help="Relative tolerance; a run with 100 times this is compared.")
    ] = 1e-10,
    points: Annotated[int, typer.Option(help="Number of output instants, ends included.")] = 1001,
    rounds: Annotated[
        int | None, typer.Option(help="Runs by which times are taken; the least counts.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Picture: .png, .svg or .pdf.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Which effects matter: the scene with each left out in turn, and what that spares."""
    from runtime.studies.effect_ranking import matters as judge
    from runtime.studies.effect_ranking.picture import check_picture, save

    try:
        if out is not None:
            check_picture(out)
        told = judge(
            model,
            scene,
            asked=quantity,
            t_end=t_end,
            t_start=t_start,
            error=error,
            analysis=analysis,
            fidelities=fidelities,
            parameters=pairs(settings, "--set"),
            guess=pairs(guess, "--guess"),
            method=method,
            rtol=rtol,
            points=points,
            rounds=rounds,
            progress=say,
        )
        if out is not None:
            say(f"Saved: {save(told, out)}")
    except InputError as problem:
        refuse(problem.problems, 2, as_json)
    except (LinkwrightError, OSError) as problem:
        refuse((str(problem),), 1, as_json)
    if as_json:
        print_json({"ok": True, **told.facts()})
        return
    from runtime.show.terminal_table import show
    from runtime.studies.effect_ranking.terminal_table import sentences, table

    show((table(told),), sentences(told))
