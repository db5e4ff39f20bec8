"""`python -m runtime matters`: the effects of a scene, ranked by their influence on a quantity."""

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


def matters(
    model: Model,
    quantity: Annotated[
        str,
        typer.Option(
            help="A coordinate, velocity, a(coordinate), reaction, energy or power at the end; "
            "max:, min:, peak:, range:, mean:, rate: or period: of one; event:EFFECT, "
            "count:EFFECT."
        ),
    ],
    scene: Scene = None,
    t_end: OptionalTEnd = None,
    t_start: MotionStart = 0.0,
    error: Annotated[
        float | None,
        typer.Option(help="Relative change that is permitted; proposes the cheapest scene."),
    ] = None,
    analysis: Annotated[
        str | None,
        typer.Option(
            help="simulate, kinematics, inverse or equilibrium (which needs no --t-end); follows "
            "from the scene unless given."
        ),
    ] = None,
    fidelities: Annotated[
        bool, typer.Option(help="Try the other fidelities of rods, contacts and frictions as well.")
    ] = True,
    settings: Parameters = None,
    guess: Guess = None,
    method: Annotated[str, typer.Option(help="Integration method, as in simulate.")] = "dop853",
    rtol: Annotated[
        float, typer.Option(help="Relative tolerance; a run with 100 times this is compared.")
    ] = 1e-10,
    points: Annotated[int, typer.Option(help="Number of output instants, ends included.")] = 1001,
    rounds: Annotated[
        int | None, typer.Option(help="Timed runs of each scene; the least time counts.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Picture: .png, .svg or .pdf.")] = None,
    as_json: Json = False,
) -> None:
    """Effect ranking: the scene without each of its effects, the change and the saving."""
    from runtime.studies.effect_ranking import matters as rank_effects
    from runtime.studies.effect_ranking.picture import check_picture, save

    with exit_on_error(as_json):
        if out is not None:
            check_picture(out)
        ranking = rank_effects(
            model,
            scene,
            asked=quantity,
            t_end=t_end,
            t_start=t_start,
            error=error,
            analysis=analysis,
            fidelities=fidelities,
            method=method,
            rtol=rtol,
            points=points,
            rounds=rounds,
            progress=write_line,
            **start_values(settings, guess),
        )
        if out is not None:
            write_line(f"Saved: {save(ranking, out)}")
    if as_json:
        print_json({"ok": True, **ranking.facts()})
        return
    from runtime.show.terminal_table import show
    from runtime.studies.effect_ranking.terminal_table import sentences, table

    show((table(ranking),), sentences(ranking))
