"""A run whose difference from a looser one is too large already is ended, and another planned."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from models.hard.suite.linkages import crank_angle
from runtime.core.outcomes import Outcome
from runtime.dynamics.formulations import formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.integrate.problem import Formulation, Options
from runtime.integrate.run import States
from runtime.integrate.run_state import RunState
from runtime.machine_facade import Machine
from runtime.studies.accuracy_target.early_termination import EarlyTermination
from runtime.studies.accuracy_target.run_difference import (
    Quantities,
    Run,
    safe_share,
    sufficient_ratio,
)
from runtime.studies.accuracy_target.tolerance_selection import (
    LAST,
    first_tolerance,
    second_tolerance,
)

T = np.linspace(0.0, 8.0, 81)
TARGET = 1e-6


def ended(largest: float) -> tuple[float, float | None]:
    """When a run ends whose difference from a looser one grows as t² up to this, and what next."""
    growing = largest * (T / T[-1]) ** 2
    path = SimpleNamespace(t=T, statistics=SimpleNamespace(steps=100))
    loose = SimpleNamespace(options=SimpleNamespace(rtol=1e-6), path=path, values=growing[:, None])
    quantities = Quantities(("x",), np.ones(1), np.array([0]))
    watch = EarlyTermination(1e-9, [cast("Run", loose)], TARGET, quantities, 0.0, 8.0)
    for t in np.arange(0.25, 8.0, 0.25):
        count = int(np.searchsorted(T, t, side="right"))
        still = np.zeros((count, 1))
        if watch(float(t), lambda count=count, still=still: (T[:count], still, still)):
            return float(t), watch.following
    return 8.0, None


def test_a_run_ends_where_its_estimated_error_is_above_the_target() -> None:
    share = safe_share(1e-3)
    assert ended(0.9 * TARGET / share) == (8.0, None)
    t, following = ended(20.0 * TARGET / share)
    assert 8.0 / np.sqrt(20.0) <= t <= 8.0 / np.sqrt(20.0) + 1.25
    assert following is not None
    # What the next run is planned for is a bound on the difference, known at the end alone.
    needed = 1e-6 * sufficient_ratio(TARGET / (20.0 * TARGET / share))
    assert 0.1 * needed < following < needed


def test_a_run_goes_on_where_the_looser_one_shows_nothing_or_little_is_left() -> None:
    share = safe_share(1e-3)
    assert ended(0.5) == (8.0, None)  # the motions part
    assert ended(1.2 * TARGET / share) == (8.0, None)  # in the last fifth of the time


def test_a_search_pays_for_a_part_of_a_run_that_will_not_do(
    library: Callable[[str, str], Machine],
) -> None:
    """Six dead centres make errors a thousand times the tolerance."""
    t = np.linspace(0.0, 10.0, 201)
    machine = library("hard/n_four_bar", "fall")
    run = machine.simulate(10.0, t, accuracy=TARGET, formulation="cartesian", progress=False)
    exact = crank_angle(2, t)
    assert np.max(np.abs(run.q("crank_0.phi") - exact) / (1.0 + np.abs(exact))) <= TARGET
    found = run.accuracy
    assert found is not None
    first, second, last = found.runs
    assert (first.outcome, second.outcome, last.outcome) == ("OK", "INACCURATE", "OK")
    assert second.evaluations < 0.8 * last.evaluations
    assert f"between rtol = {first.rtol:.1e} and {last.rtol:.1e}" in found.means
    again = machine.simulate(10.0, t, rtol=last.rtol, method=last.method, progress=False)
    np.testing.assert_array_equal(again.samples.q, run.samples.q)


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
def test_a_watched_run_shows_all_coordinates_of_its_samples(
    library: Callable[[str, str], Machine], formulation: Formulation
) -> None:
    mechanism = library("hard/n_four_bar", "fall").mechanism
    ready = PreparedSimulation(mechanism, 2.0, t_start=0.0, parameters=None, guess=None, start=None)
    taken = formulate(ready, formulation, "dop853", "step")
    options = Options(rtol=1e-9, t_eval=np.linspace(0.0, 2.0, 41), chunk=2)
    whole = ready.run(taken, options, lambda fraction: None)
    seen: dict[float, np.ndarray] = {}

    def watch(t: float, states: Callable[[], States]) -> bool:
        times, q, v = states()
        seen.update(zip(times.tolist(), np.hstack([q, v]), strict=True))
        return t > 1.5

    part = ready.run(taken, options, lambda fraction: None, watch)
    assert (whole.outcome, part.outcome) == (Outcome.OK, Outcome.INACCURATE)
    count = len(part.t)
    assert 1.4 < part.t[-1] < 2.0
    np.testing.assert_array_equal(part.q, whole.q[:count])
    assert len(seen) > count // 2  # all but the last ones before each change of coordinates
    for t, state in seen.items():
        k = int(np.searchsorted(whole.t, t))
        np.testing.assert_allclose(state, np.hstack([whole.q[k], whole.v[k]]), atol=1e-12)


def test_second_runs_are_not_so_tight_that_rounding_makes_them_err_more() -> None:
    path: Any = SimpleNamespace(methods=((0.0, "dop853"),))
    for target in np.geomspace(1e-12, 0.1, 40):
        first = first_tolerance(float(target))
        assert first > second_tolerance("dop853", float(target), first, path) >= LAST
        assert first > second_tolerance("bdf", float(target), first, path) >= LAST


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_decays_in_a_run_decays_in_both_kinds_of_coordinates(
    library: Callable[[str, str], Machine], monkeypatch: pytest.MonkeyPatch, sign: float
) -> None:
    """Also where the last part of the run is in the other kind."""
    mechanism = library("hard/n_four_bar", "fall").mechanism
    kinds = len(mechanism.reduced.kept), len(mechanism.description.coordinates)
    decay = property(lambda state: sign * state.system.coordinates)
    monkeypatch.setattr(RunState, "mean_decay", decay)
    ready = PreparedSimulation(mechanism, 1.0, t_start=0.0, parameters=None, guess=None, start=None)
    taken = formulate(ready, "reduced", "dop853", "step")
    path = taken.run(Options(rtol=1e-6, t_eval=np.linspace(0.0, 1.0, 11)), lambda t, steps: None)
    assert path.outcome.name == "OK"
    assert path.decay == min(sign * count for count in kinds)
