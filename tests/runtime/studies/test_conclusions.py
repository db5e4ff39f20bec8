"""Conclusions from runs: times at an accuracy, the Pareto front, sentences."""

import json
import math

from numpy.testing import assert_allclose

from runtime.accuracy_target.error_norms import Errors, Scale
from runtime.studies.conclusions import (
    best_at,
    effectivity,
    front,
    sentences,
    slope,
    time_at,
)
from runtime.studies.diagram import (
    Check,
    Choice,
    Line,
    Point,
    Reference,
    WorkPrecision,
)
from runtime.studies.harness import Setting


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
    best = best_at(study(SLOW, FAST), 1e-6)
    assert best.line is FAST
    assert best_at(study(SLOW, floor=1e-5), 1e-6) is None
    assert_allclose(slope(SLOW), 1.0)
    assert_allclose(effectivity(SLOW), 1.0)
    assert slope(Line(Setting("bdf"), (point(1e-2, 1e-2, 1.0),))) is None


def test_no_run_beats_those_of_the_front() -> None:
    runs = front((SLOW, FAST))
    assert [(p.worst, p.seconds) for p in runs] == [(1e-2, 1e-3), (1e-7, 2e-3), (1e-10, 16e-3)]
    unknown = Line(Setting("bdf"), (point(1e-2, 1e-13, 3e-3, beyond=True),))
    assert [p.seconds for p in front((SLOW, FAST, unknown))] == [1e-3, 2e-3, 3e-3]


def test_sentences_follow_from_the_runs() -> None:
    found = study(
        SLOW,
        FAST,
        Line(Setting("dop853", "cartesian", "stage"), (point(1e-6, 1e-6, 8e-3),)),
        choices=(
            Choice("rod as link", "coupler", "s2", Setting("dop853"), point(1e-4, 1e-2, 5e-4)),
            Choice("ring as lumped", "coupler", "s3", reason="It does not assemble."),
        ),
    )
    lines = list(sentences(found))
    slow, fast, steps = time_at(SLOW, 1e-9), time_at(FAST, 1e-6), time_at(SLOW, 1e-6)
    assert lines[0].startswith(
        f"Three more digits, 9 instead of 6, cost {slow / fast:.2g} times the time: "
    )
    text = " ".join(lines)
    assert "Correction at every stage takes 2.00 times the time" in text
    assert f"dop853, reduced takes {fast / steps:.2f} times the time of dop853, cartesian" in text
    assert (
        "rod as link keeps 2.0 digits, however tight the tolerance, after 0.5 ms; the declared "
        "scene has as many after 1 ms."
    ) in lines
    assert "ring as lumped: not run. It does not assemble." in lines
    assert "Stopped." in next(line for line in lines if "1 of 3 runs did not" in line)
    nothing = study(Line(Setting("bdf"), (point(1e-2, 0.02, 1.0),)))
    assert next(sentences(nothing)).startswith("No run has more than 1.7 digits")


def test_long_reasons_end_at_a_word_on_a_screen_and_nowhere_in_records() -> None:
    reason = " ".join(f"reason{k}" for k in range(60))
    found = study(
        SLOW,
        Line(Setting("radau5"), refused=reason),
        Line(Setting("bdf"), (point(1e-2, 1e-2, 1e-3), Point(1e-4, "SINGULAR", reason))),
        choices=(Choice("ring as lumped", "coupler", "s3", reason=reason),),
    )
    cut = [line for line in sentences(found) if "reason0" in line]
    assert len(cut) == 3
    for line in cut:
        *_, last, dots = line.split()
        assert dots == "…"
        assert last in reason.split()
        assert len(line[line.index("reason0") :]) <= 160
    facts = json.loads(json.dumps(found.facts(), allow_nan=False))
    assert sum(line.endswith(reason) for line in facts["sentences"]) == 3
