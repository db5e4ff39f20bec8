"""What is read from runs: scaled errors, times at an accuracy, the front, sentences."""

import json
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from numpy.testing import assert_allclose

from runtime import load
from runtime.studies.error_norms import Errors, Scale, errors, kindred, scales
from runtime.studies.work_precision import (
    Check,
    Choice,
    Line,
    Point,
    Reference,
    Setting,
    WorkPrecision,
)
from runtime.studies.work_precision.diagram import DONE, TIMEOUT
from runtime.studies.work_precision.interpretation import (
    best_at,
    effectivity,
    front,
    sentences,
    slope,
    time_at,
)
from runtime.studies.work_precision.settings_grid import FURTHER, RTOLS
from runtime.studies.work_precision.timed_runs import Stopwatch, take_turns


def point(rtol: float, worst: float, seconds: float, *, beyond: bool = False) -> Point:
    found = Errors(worst, worst, worst, worst, {"positions": worst}, {"x": worst})
    return Point(rtol, "OK", "", found, beyond, seconds, 1.0, 5)


def study(*made: Line, floor: float = 1e-12, choices: tuple[Choice, ...] = ()) -> WorkPrecision:
    reference = Reference("dop853", False, (Check("radau5", floor),), floor)
    scale = Scale("x", "m", "positions", 1.0)
    return WorkPrecision("m", "s", 0.0, 1.0, 10, (scale,), "", 1.0, 10, reference, made, choices)


SLOW = Line(
    Setting("dop853"),
    (point(1e-2, 1e-2, 1e-3), point(1e-6, 1e-6, 4e-3), point(1e-10, 1e-10, 16e-3)),
)
FAST = Line(
    Setting("dop853", "reduced"),
    (point(1e-2, 2e-2, 1e-3), point(1e-6, 1e-7, 2e-3), Point(1e-10, "SINGULAR", "Stopped.")),
)


def test_times_lie_on_lines_in_logarithms() -> None:
    assert_allclose(time_at(SLOW, 1e-4), 2e-3, rtol=1e-12)
    assert_allclose(time_at(SLOW, 1e-8), 8e-3, rtol=1e-12)
    assert time_at(SLOW, 0.5) == 1e-3
    assert time_at(SLOW, 1e-11) is None
    assert time_at(FAST, 1e-9) is None
    flat = Line(Setting("auto"), (point(1e-3, 1e-3, 3e-3), point(1e-6, 1e-6, 2e-3)))
    assert time_at(flat, 1e-3) == time_at(flat, 1e-6) == 2e-3
    lost = Line(Setting("auto"), (point(1e-3, math.inf, 1e-3), point(1e-6, 1e-6, 2e-3)))
    assert time_at(lost, 1e-3) == 2e-3
    told = study(SLOW, FAST)
    best = best_at(told, 1e-6)
    assert best is not None
    assert best.line is FAST
    assert best_at(study(SLOW, floor=1e-5), 1e-6) is None
    assert_allclose(slope(SLOW), 1.0)
    assert_allclose(effectivity(SLOW), 1.0)
    assert slope(Line(Setting("bdf"), (point(1e-2, 1e-2, 1.0),))) is None


def test_the_front_has_what_nothing_beats() -> None:
    runs = front((SLOW, FAST))
    assert [(setting.title, p.seconds) for setting, p in runs] == [
        ("dop853, cartesian", 1e-3),
        ("dop853, reduced", 2e-3),
        ("dop853, cartesian", 16e-3),
    ]
    unknown = Line(Setting("bdf"), (point(1e-2, 1e-13, 3e-3, beyond=True),))
    assert [p.seconds for _, p in front((SLOW, FAST, unknown))] == [1e-3, 2e-3, 3e-3]


def test_sentences_follow_from_the_runs() -> None:
    told = study(
        SLOW,
        FAST,
        Line(Setting("dop853", "cartesian", "stage"), (point(1e-6, 1e-6, 8e-3),)),
        choices=(
            Choice("rod as link", "coupler", "s2", Setting("dop853"), point(1e-4, 1e-2, 5e-4)),
            Choice("ring as lumped", "coupler", "s3", reason="It does not assemble."),
        ),
    )
    said = list(sentences(told))
    slow, fast, steps = time_at(SLOW, 1e-9), time_at(FAST, 1e-6), time_at(SLOW, 1e-6)
    assert slow is not None
    assert fast is not None
    assert steps is not None
    assert said[0].startswith(
        f"Three more digits, 9 in place of 6, cost {slow / fast:.2g} times the time: "
    )
    text = " ".join(said)
    assert "Correction at every stage takes 2.00 times the time" in text
    assert f"dop853, reduced takes {fast / steps:.2f} times the time of dop853, cartesian" in text
    assert (
        "rod as link keeps 2.0 digits, however tight the tolerance, after 0.5 ms; the scene as "
        "declared has as many after 1 ms."
    ) in said
    assert "ring as lumped: not run. It does not assemble." in said
    assert "Stopped." in next(line for line in said if "1 of 3 runs did not" in line)
    nothing = study(Line(Setting("bdf"), (point(1e-2, 0.02, 1.0),)))
    assert next(sentences(nothing)).startswith("No run has more than 1.7 digits")


def test_long_reasons_end_at_a_word_on_a_screen_and_nowhere_in_records() -> None:
    reason = " ".join(f"reason{k}" for k in range(60))
    told = study(
        SLOW,
        Line(Setting("radau5"), refused=reason),
        Line(Setting("bdf"), (point(1e-2, 1e-2, 1e-3), Point(1e-4, "SINGULAR", reason))),
        choices=(Choice("ring as lumped", "coupler", "s3", reason=reason),),
    )
    cut = [line for line in sentences(told) if "reason0" in line]
    assert len(cut) == 3
    for line in cut:
        *_, last, dots = line.split()
        assert dots == "…"
        assert last in reason.split()
        assert len(line[line.index("reason0") :]) <= 160
    facts = json.loads(json.dumps(told.facts(), allow_nan=False))
    assert sum(line.endswith(reason) for line in facts["sentences"]) == 3


def test_errors_are_those_of_the_formula(rig: str, folder: Path) -> None:
    by = (
        Scale("x", "m", "positions", 2.0),
        Scale("v", "m/s", "velocities", 4.0),
        Scale("f", "N", "others", 10.0),
    )
    true = np.array([[1.0, -4.0, 0.0], [0.0, 0.0, 30.0]])
    found = true + np.array([[0.3, 0.0, 5.0], [0.0, -0.2, np.nan]])
    told = errors(found, true, by)
    assert_allclose(told.worst, 0.1)  # 0.3 / (2 + 1)
    assert_allclose(told.end, 0.05)  # 0.2 / (4 + 0)
    assert_allclose(told.rms, math.sqrt((0.1**2 + 0.05**2) / 4.0))
    assert_allclose(told.relative, math.sqrt((0.15**2 + 0.05**2) / 4.0))
    assert told.groups["others"] == math.inf
    assert_allclose(told.groups["velocities"], 0.05)
    assert_allclose(told.each["x"], 0.1)
    assert errors(found[:1, 2:], true[:1, 2:], by[2:]).worst == 0.5
    machine = load(rig, "swing", folder=folder).description
    names = ("body.x", "body.phi", "body.vx", "body.vy", "kinetic")
    sizes = np.array([1.5, 1.5, 1.0])
    reference = np.array([[0.5, 0.0, 2.0, 0.0, 7.0], [0.1, 0.0, -2.5, 0.0, 3.0]])
    made = scales(names, ("m",) * 5, machine, sizes, reference)
    assert [scale.value for scale in made] == [1.5, 1.0, 2.5, 1.5, 7.0]
    assert [scale.group for scale in made][2:] == ["velocities", "velocities", "others"]
    made = scales(names, ("m",) * 5, machine, sizes, reference, (0.0, 0.0, 0.0, 0.0, 20.0))
    assert [scale.value for scale in made] == [1.5, 1.0, 2.5, 1.5, 20.0]


def test_instants_at_which_the_reference_is_no_number_are_not_judged() -> None:
    """As reactions at a singular position."""
    true = np.array([[4.0], [np.nan], [-10.0]])
    sizes = np.ones(0)
    nothing = SimpleNamespace(coordinates=())
    by = scales(("A.fx",), ("N",), nothing, sizes, true)  # type: ignore[arg-type]
    assert by[0].value == 10.0
    told = errors(true + 2.0, true, by)
    assert_allclose(told.worst, 2.0 / 14.0)
    assert_allclose(told.relative, 2.0 / 10.0 * math.sqrt(2.0 / 3.0))


def test_a_part_is_measured_by_the_whole(rig: str, folder: Path) -> None:
    """Rounding in an energy that stays zero is no error of a hundred per cent."""
    result = load(rig, "swing", folder=folder).simulate(0.5, [0.25, 0.5], progress=False)
    energies = np.abs(result.samples.energy).max()
    assert kindred(result, "total") == kindred(result, "kinetic") == energies
    assert kindred(result, "body.x") == 0.0


def test_the_grid_is_that_of_the_definition() -> None:
    assert len(RTOLS) == 17
    assert_allclose((RTOLS[0], RTOLS[1], RTOLS[-1]), (1e-2, 10**-2.5, 1e-10))
    assert_allclose((FURTHER[0], FURTHER[-1]), (10**-10.5, 1e-12))


class Interrupted:
    """A runner of runs of 3 s, of which all but the first are cut short after 2 s."""

    def run(self, setting: Setting, rtol: float, watch: Stopwatch) -> tuple[None, str]:
        watch.times.append(2.0 if watch.times else 3.0)
        return None, TIMEOUT if len(watch.times) > 1 else DONE


def test_what_the_limit_cut_short_is_no_time_of_a_run() -> None:
    runner, watch = Interrupted(), Stopwatch()
    runner.run(Setting("bdf"), 1e-6, watch)
    take_turns(runner, [(Setting("bdf"), 1e-6, watch)], 5, 100.0)  # type: ignore[arg-type]
    assert watch.times == [3.0]
