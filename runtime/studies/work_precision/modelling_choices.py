"""Errors of modelling: the scene in other fidelities, against the reference of the scene itself.

However tight the tolerance, the error of the model remains. The loosest run whose error is hardly
anything else shows the cost of the choice; in looser runs the two errors add up, or cancel.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from codegen.errors import InputError, LinkwrightError
from codegen.scene_variants import declared, variants
from runtime.studies.timing import Stopwatch
from runtime.studies.work_precision.diagram import DONE, Choice, Point, Setting
from runtime.studies.work_precision.measurement import Measurement, point_of, reason_of, with_time
from runtime.studies.work_precision.reference_solution import ReferenceSolution
from runtime.studies.work_precision.timed_runs import Runner, time_runs

if TYPE_CHECKING:
    from codegen import Model, Scene

RTOLS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
_MODEL_ERROR = 0.1  # accuracy: share by which a run's error may differ from the tightest run's
_LEFT_OUT = "none"


class Alternative(NamedTuple):
    """A scene that models the same machine: its title, the kind of its difference, the scene."""

    title: str
    kind: str
    scene: "Scene"


def alternatives(
    model: "Model", declared_scene: "Scene", modelling: bool, beside: "Sequence[str | Scene]"
) -> tuple[Alternative, ...]:
    """Scenes to compare with the declared one.

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
    found = [
        Alternative(change.title, change.kind, change.of(declared_scene))
        for change in (variants(model, declared_scene) if modelling else ())
        if change.word != _LEFT_OUT
    ]
    named = (declared(model, scene)[1] for scene in beside)
    return (*found, *(Alternative(scene.name, "scene", scene) for scene in named))


def measure_choices(
    measurement: Measurement,
    others: Sequence[Alternative],
    prepare: Callable[["Scene"], Runner],
    settings: Sequence[Setting],
) -> tuple[Choice, ...]:
    """Each of the scenes, run until the error of its model is all that is left.

    Parameters
    ----------
    prepare
        Scene → its runner; raises LinkwrightError where it does not assemble.
    settings
        In which a scene is tried, until one runs.
    """
    found = []
    for title, kind, scene in others:
        measurement.progress(f"{measurement.runner.machine.model}/{scene.name}")
        choice = Choice(title, kind, scene.name)
        try:
            runner = prepare(scene)
        except LinkwrightError as error:
            found.append(replace(choice, reason=reason_of(error)))
        else:
            found.append(_measure(choice, measurement, runner, settings))
    return tuple(found)


def _measure(
    choice: Choice, measurement: Measurement, runner: Runner, settings: Sequence[Setting]
) -> Choice:
    """In the first setting that works."""
    reasons = []
    for setting in settings:
        try:
            point, watch = _cheapest(runner, measurement.reference, setting)
            time_runs([watch], measurement.rounds, measurement.least)
        except InputError as error:
            reasons.append(reason_of(error))
        except LinkwrightError as error:
            reasons.append(f"{setting.title}: {error}")
        else:
            return replace(choice, setting=setting, point=with_time(point, watch))
    return replace(choice, reason=" ".join(dict.fromkeys(reasons)))


def _cheapest(
    runner: Runner, reference: ReferenceSolution, setting: Setting
) -> tuple[Point, Stopwatch]:
    """The loosest run whose error is that of the model, as it is in all tighter runs."""
    points: list[tuple[Point, Stopwatch]] = []
    for rtol in RTOLS:
        run = runner.run(setting, rtol)
        if run.outcome == DONE:
            watch = runner.stopwatch(setting, rtol, run.seconds)
            points.append((point_of(run, rtol, reference), watch))
        elif rtol == RTOLS[-1]:
            raise LinkwrightError(run.result.message)
    worst = [point.errors.worst for point, _ in points if point.errors is not None]
    other = [k for k, e in enumerate(worst) if abs(e - worst[-1]) > _MODEL_ERROR * worst[-1]]
    return points[other[-1] + 1 if other else 0]
