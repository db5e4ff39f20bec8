"""`python -m runtime matters` and `python -m runtime accuracy`: the studies of a scene."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from runtime.cli import common
from runtime.cli.case_of_command import source
from runtime.cli.common import (
    Generated,
    Guess,
    Json,
    Model,
    MotionStart,
    OptionalTEnd,
    Scene,
    Start,
    Values,
    option,
)
from runtime.cli.run_options import with_run_options, words

if TYPE_CHECKING:
    from runtime.studies.effect_ranking import Matters
    from runtime.studies.work_precision import WorkPrecision

Answer = TypeVar("Answer", "Matters", "WorkPrecision")


@partial(with_run_options, without=("accuracy",))
def matters(
    model: Model,
    quantity: Annotated[
        str,
        option("A coordinate, velocity, a(coordinate), reaction, energy or power at the end; max:, "
               "min:, peak:, range:, mean:, rate: or period: of one; event:EFFECT, count:EFFECT."),
    ],
    scene: Scene = None, t_end: OptionalTEnd = None, t_start: MotionStart = 0.0,
    error: Annotated[
        float | None, option("Relative change that is permitted; proposes the cheapest scene.")
    ] = None,
    analysis: Annotated[
        str | None,
        option("simulate, kinematics, inverse-dynamics or equilibrium (which needs no --t-end); "
               "follows from the scene unless given."),
    ] = None,
    fidelities: Annotated[
        bool, option("Try the other fidelities of rods, contacts and frictions as well.")
    ] = True,
    settings: Values = None, start: Start = None, guess: Guess = None,
    generated: Generated = None,
    method: Annotated[str, option("Integration method, as in simulate.")] = "dop853",
    formulation: Annotated[str | None, option("cartesian or reduced, as in simulate.")] = None,
    rtol: Annotated[
        float, option("Relative tolerance; a run with 100 times this is compared.")
    ] = 1e-10,
    points: Annotated[int, option("Number of output instants, ends included.")] = 1001,
    rounds: Annotated[
        int | None, option("Timed runs of each scene; the least time counts.")
    ] = None,
    out: Annotated[Path | None, option("Picture: .png, .svg or .pdf.")] = None,
    as_json: Json = False, **run: Any,
) -> None:  # fmt: skip
    """Effect ranking: the scene without each of its effects, the change and the saving."""
    from runtime.studies.effect_ranking import matters as rank_effects
    from runtime.studies.effect_ranking import picture

    def study() -> "Matters":
        return rank_effects(
            *source(model, scene), asked=quantity, t_end=t_end, t_start=t_start, error=error,
            analysis=analysis, fidelities=fidelities, method=method, formulation=formulation,
            rtol=rtol, points=points, rounds=rounds, generated=generated,
            progress=common.write_line,
            **words(run, common.start_values(settings, guess, start)),
        )  # fmt: skip

    ranking = _answer(study, picture, out, as_json)
    if not as_json:
        from runtime.show.table_formatting import show
        from runtime.studies.effect_ranking.terminal_table import sentences, table

        show((table(ranking),), sentences(ranking))


@partial(with_run_options, without=("accuracy", "rtol", "correction"))
def accuracy(
    model: Model, scene: Scene = None,
    quantity: Annotated[
        list[str] | None,
        option("A series that is compared, such as crank.phi; again for more. Unless given, the "
               "coordinates that the scene starts from, and their velocities. a.x|b.x is whichever "
               "of them a scene has."),
    ] = None,
    t_end: OptionalTEnd = None, t_start: MotionStart = 0.0,
    method: Annotated[
        list[str] | None, option("Integration method; again for more. All unless given.")
    ] = None,
    formulation: Annotated[
        list[str] | None, option("cartesian or reduced; both unless given.")
    ] = None,
    reference: Annotated[
        Path | None,
        option("A .csv file with columns t, in s, and the quantities: the reference."),
    ] = None,
    points: Annotated[int, option("Instants at which runs are compared.")] = 200,
    modelling: Annotated[
        bool, option("Run the other fidelities of rods, contacts and frictions as well.")
    ] = True,
    beside: Annotated[
        list[str] | None, option("A further scene that models the same machine; again for more.")
    ] = None,
    building: Annotated[
        bool | None, option("Build the scene anew and time each stage; not with --quick.")
    ] = None,
    quick: Annotated[
        bool, option("Four tolerances in place of seventeen, few repeats.", "--quick")
    ] = False,
    limit: Annotated[float, option("Seconds that a run may take.")] = 10.0,
    settings: Values = None, start: Start = None, guess: Guess = None,
    generated: Generated = None,
    out: Annotated[
        Path | None, option("Folder for the picture and the runs as JSON lines.")
    ] = None,
    as_json: Json = False, **run: Any,
) -> None:  # fmt: skip
    """Work-precision: digits against time, by method, formulation and modelling choice."""
    from runtime.integrate.method import METHODS
    from runtime.studies.work_precision import accuracy as work_precision
    from runtime.studies.work_precision import picture
    from runtime.studies.work_precision.diagram import FORMULATIONS

    def study() -> "WorkPrecision":
        return work_precision(
            *source(model, scene), quantities=tuple(quantity or ()), t_end=t_end, t_start=t_start,
            methods=tuple(method or METHODS), formulations=tuple(formulation or FORMULATIONS),
            points=points, reference=reference, modelling=modelling, beside=tuple(beside or ()),
            building=building, quick=quick, limit=limit, generated=generated,
            progress=common.write_line,
            **words(run, common.start_values(settings, guess, start)),
        )  # fmt: skip

    diagram = _answer(study, picture, out, as_json)
    if not as_json:
        from runtime.show.table_formatting import show
        from runtime.studies.work_precision.interpretation import sentences
        from runtime.studies.work_precision.terminal_table import score, work

        show((score(diagram), work(diagram)), sentences(diagram))


def _answer(
    study: Callable[[], Answer], picture: ModuleType, out: Path | None, as_json: bool
) -> Answer:
    """Run a study and save its picture; with --json print its facts."""
    with common.exit_on_error(as_json):
        if out is not None:
            picture.check_place(out)
        answer = study()
        if out is not None:
            for path in picture.save(answer, out):
                common.write_line(f"Saved: {path}")
    if as_json:
        common.print_json({"ok": True, **answer.facts()})
    return answer
