"""The difference of two runs: how it is scaled and grows, and when two runs are no evidence."""

from pathlib import Path

import numpy as np
import pytest

from codegen.errors import AnalysisError
from runtime.core.outcomes import Outcome
from runtime.machine import Machine
from runtime.studies.accuracy_target.run_difference import Difference, columns, difference, tenfold
from tests.runtime.test_asked_accuracy import of


@pytest.fixture(scope="module")
def thrown(root: Path, workshop: Path) -> Machine:
    return of(root, workshop, "hard/double_pendulum", "thrown")


def of_growth(error: np.ndarray, t: np.ndarray) -> Difference:
    return Difference(t, error[:, None], np.ones(1))


def test_exponential_growth_is_told_from_powers_of_time() -> None:
    t = np.linspace(0.0, 10.0, 401)
    wave = 1.0 + 0.5 * np.sin(30.0 * t)
    assert tenfold(of_growth(1e-11 * 10.0 ** (t / 1.5) * wave, t)) == pytest.approx(1.5, rel=0.1)
    for power in (0, 1, 2, 3):
        assert tenfold(of_growth(1e-8 * t**power * wave, t)) is None
    assert tenfold(of_growth(np.zeros(401), t)) is None


def test_errors_are_scaled_by_size_and_value(thrown: Machine) -> None:
    told = thrown.description
    sizes = np.full(len(told.coordinates), 2.0)
    chosen = columns(told, ("upper.x", "hinge.fx"), sizes)
    assert not chosen.of_state
    t = np.array([0.0, 1.0])
    first, second = np.array([[1.0, 8.0], [1.0, 0.0]]), np.array([[1.5, 10.0], [1.0, 0.0]])
    found = difference(t, first, second, chosen)
    np.testing.assert_allclose(found.scaled, [[0.5 / 3.5, 2.0 / 20.0], [0.0, 0.0]])
    np.testing.assert_allclose(found.scales, [2.0, 10.0])
    assert found.within(0.2) == 2
    assert found.within(0.1) == 0


def test_what_is_no_number_in_one_run_only_is_a_difference(thrown: Machine) -> None:
    chosen = columns(thrown.description, ("hinge.fx",), np.ones(6))
    t, nan = np.array([0.0, 1.0]), np.nan
    found = difference(t, np.array([[nan], [1.0]]), np.array([[nan], [nan]]), chosen)
    assert found.scaled[0, 0] == 0.0
    assert np.isinf(found.scaled[1, 0])


def test_an_instant_without_a_number_hides_no_other(thrown: Machine) -> None:
    """Reactions are nan at a singular position; the instants around it are compared as ever."""
    chosen = columns(thrown.description, ("hinge.fx",), np.ones(6))
    t, first = np.array([0.0, 1.0, 2.0]), np.array([[8.0], [np.nan], [5.0]])
    found = difference(t, first, first + 2.0, chosen)
    np.testing.assert_allclose(found.scaled[:, 0], [0.1, 0.0, 2.0 / 17.0])
    whole = difference(t, first, first + 2.0, chosen, np.array([90.0]))
    np.testing.assert_allclose(whole.scaled[:, 0], [0.02, 0.0, 2.0 / 97.0])


def test_parts_of_a_force_are_measured_by_the_force(thrown: Machine) -> None:
    result = thrown.simulate(0.5, [0.25, 0.5], progress=False)
    most = [np.abs(result.series(f"hinge.{part}")[0]).max() for part in ("fx", "fy")]
    assert max(most) > min(most) > 0.0
    chosen = columns(thrown.description, ("hinge.fx", "hinge.fy", "total"), np.ones(6))
    energies = np.abs(result.samples.energy).max()
    np.testing.assert_allclose(chosen.wholes(result), [max(most), max(most), energies])


@pytest.mark.parametrize(("method", "longest"), [("dop853", 0.01), ("dopri5", 0.003)])
def test_what_the_longest_step_bounds_is_estimated_too(
    thrown: Machine, method: str, longest: float
) -> None:
    """Two runs with the same steps agree, and are off alike."""
    times = np.linspace(0.0, 8.0, 101)
    found = thrown.simulate(
        8.0, times, accuracy=0.1, max_step=longest, method=method, progress=False
    )
    exact = thrown.simulate(8.0, times, rtol=1e-13, progress=False)
    told = found.accuracy
    assert told is not None
    worst = max(
        (np.abs(x - y) / (row.scale + np.abs(y))).max()
        for row in told.quantities
        for x, y in [(found.series(row.name)[0], exact.series(row.name)[0])]
    )
    assert worst / 10.0 < told.estimated < 0.1


def test_what_was_not_compared_is_not_told(root: Path, workshop: Path) -> None:
    """The tighter run uses its steps up before the looser one: what follows is not delivered."""
    pendulum = of(root, workshop, "hard/pendulum", "point")
    for steps in (160, 250):
        found = pendulum.simulate(20.0, accuracy=1e-5, max_steps=steps, progress=False)
        checked = pendulum.simulate(
            20.0, rtol=found.accuracy.runs[-1].rtol, max_steps=steps, progress=False
        )
        assert checked.outcome is Outcome.MAX_STEPS
        assert found.outcome is Outcome.INACCURATE
        assert found.t[-1] <= checked.t[-1]
        assert found.accuracy.horizon == found.t[-1]
        assert "ends before (MAX_STEPS)" in found.message


def test_an_instant_that_is_right_is_kept_though_it_is_the_only_one(thrown: Machine) -> None:
    found = thrown.simulate(30.0, [10.0, 30.0], accuracy=1e-6, progress=False)
    assert found.outcome is Outcome.INACCURATE
    assert found.t.tolist() == [10.0]
    with pytest.raises(AnalysisError, match=r"first instant, t = 30 s"):
        thrown.simulate(30.0, [30.0], accuracy=1e-6, progress=False)


def test_rounding_is_not_taken_to_fall(thrown: Machine) -> None:
    told = thrown.simulate(0.05, [0.05], accuracy=1e-10, progress=False).accuracy
    assert told is not None
    assert 0.0 < told.estimated < 2e-13
    assert told.estimated == told.runs[-1].difference
