"""Modelling choices are accuracy too: the scene with something taken otherwise, against itself.

Its motion is compared with the reference of the scene as it is declared. However tight the
tolerance, the error of the model remains; the loosest run in which there is hardly anything else is
what the choice costs. In looser runs the errors of both add up, or cancel.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from codegen.errors import InputError, LinkwrightError
from codegen.scene_variants import declared, variants
from runtime.studies.effect_ranking.trial_run import Plan
from runtime.studies.work_precision.diagram import DONE, Choice, Point, Setting
from runtime.studies.work_precision.measurement import judged, timed
from runtime.studies.work_precision.reference_solution import Truth
from runtime.studies.work_precision.timed_runs import Runner, Stopwatch, take_turns

if TYPE_CHECKING:
    from codegen import Model, Scene
    from runtime.machine import Machine

RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
SAME = 0.1
"""Share by which the error of a run may differ from the tightest run's and be that of the model."""
_LEFT_OUT = "none"


class Alternative(NamedTuple):
    """A scene that stands for the same machine: its title, what is other in it, and itself."""

    title: str
    kind: str
    scene: "Scene"


def alternatives(
    read: "Model", chosen: "Scene", modelling: bool, beside: "Sequence[str | Scene]"
) -> tuple[Alternative, ...]:
    """Scenes to judge.

    Parameters
    ----------
    modelling
        Whether the other fidelities of couplers, contacts, frictions and groups are among them.
    beside
        Scenes that the user named.

    Raises
    ------
    InputError
        If the model has no such scene.
    """
    made = [
        Alternative(change.title, change.kind, change.of(chosen))
        for change in (variants(read, chosen) if modelling else ())
        if change.word != _LEFT_OUT
    ]
    named = (declared(read, scene)[1] for scene in beside)
    return (*made, *(Alternative(scene.name, "scene", scene) for scene in named))


def choices(
    others: Sequence[Alternative],
    load: Callable[["Scene"], "Machine"],
    runner: Runner,
    plan: Plan,
    truth: Truth,
    settings: Sequence[Setting],
    rounds: int,
    least: float,
    progress: Callable[[str], None],
) -> tuple[Choice, ...]:
    """Each of the scenes, run until its error is its own.

    Parameters
    ----------
    load
        Scene → machine.
    runner
        Of the scene as it is.
    plan
        Parameters and guess, of which a scene gets those that it has.
    settings
        In which a scene is tried, until one runs.
    rounds, least
        As in `take_turns`.
    """
    made = []
    for title, kind, scene in others:
        progress(f"{runner.machine.model}/{scene.name}")
        told = Choice(title, kind, scene.name)
        try:
            machine = load(scene)
            parameters = plan.parameters_of(machine)
            begin = machine.assemble(plan.guess_of(machine), parameters, plan.t_start)
            own = replace(runner, machine=machine, begin=begin, parameters=parameters)
        except LinkwrightError as error:
            made.append(replace(told, reason=_reason(error)))
            continue
        made.append(_tried(told, own, truth, settings, rounds, least))
    return tuple(made)


def _tried(
    told: Choice,
    runner: Runner,
    truth: Truth,
    settings: Sequence[Setting],
    rounds: int,
    least: float,
) -> Choice:
    """In the first setting that works."""
    reasons = []
    for setting in settings:
        try:
            point, watch = _cheapest(runner, truth, setting)
            take_turns(runner, [(setting, point.rtol, watch)], rounds, least)
        except InputError as error:
            reasons.append(_reason(error))
        except LinkwrightError as error:
            reasons.append(f"{setting.title}: {_reason(error)}")
        else:
            return replace(told, setting=setting, point=timed(point, watch))
    return replace(told, reason=" ".join(dict.fromkeys(reasons)))


def _cheapest(runner: Runner, truth: Truth, setting: Setting) -> tuple[Point, Stopwatch]:
    """The loosest run whose error is that of the model, as it is in all that are tighter."""
    points: list[tuple[Point, Stopwatch]] = []
    for rtol in RTOLS:
        watch = Stopwatch()
        result, outcome = runner.run(setting, rtol, watch)
        if outcome == DONE:
            points.append((judged(result, outcome, rtol, truth), watch))
        elif rtol == RTOLS[-1]:
            raise LinkwrightError(result.message)
    worst = [point.errors.worst for point, _ in points if point.errors is not None]
    other = [k for k, error in enumerate(worst) if abs(error - worst[-1]) > SAME * worst[-1]]
    return points[other[-1] + 1 if other else 0]


def _reason(error: LinkwrightError) -> str:
    return " ".join(error.problems) if isinstance(error, InputError) else str(error)
