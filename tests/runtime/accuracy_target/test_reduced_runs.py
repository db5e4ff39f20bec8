"""A search in reduced coordinates: what decays in its runs, and runs that a check contradicts."""

from collections.abc import Callable

import numpy as np
import pytest

from models.hard.suite.linkages import crank_angle
from runtime.core.outcomes import Outcome
from runtime.dynamics.checks import energy_balance
from runtime.dynamics.formulations import formulate
from runtime.dynamics.prepared_simulation import PreparedSimulation
from runtime.integrate.checkpoints import Checkpoints
from runtime.integrate.problem import Options
from runtime.integrate.run_state import RunState
from runtime.machine_facade import Machine


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
    path = taken.run(Options(rtol=1e-6, t_eval=np.linspace(0.0, 1.0, 11)), Checkpoints())
    assert path.outcome.name == "OK"
    assert path.decay == min(sign * count for count in kinds)


def test_a_search_goes_on_in_all_coordinates_where_a_check_contradicts_reduced_ones(
    library: Callable[[str, str], Machine], monkeypatch: pytest.MonkeyPatch
) -> None:
    machine, t = library("hard/n_four_bar", "fall"), np.linspace(0.0, 1.0, 21)
    found = iter(["The energy changes."])  # of the first result alone
    monkeypatch.setattr(energy_balance, "describe_unexplained_energy", lambda *_: next(found, ""))
    run = machine.simulate(1.0, t, accuracy=1e-6, formulation="reduced", progress=False)
    assert run.outcome is Outcome.OK
    assert run.accuracy.formulation == "cartesian"
    assert [one.formulation for one in run.accuracy.runs][-2:] == ["cartesian"] * 2
    assert "The energy changes" in run.accuracy.means
    assert run.message.endswith("which is thrown away. The energy changes.")
    assert "rely" not in run.message + run.accuracy.means
    delivered = run.accuracy.runs[-1]
    again = machine.simulate(
        1.0, t, rtol=delivered.rtol, method=delivered.method, formulation="cartesian"
    )
    np.testing.assert_array_equal(again.samples.q, run.samples.q)
    exact = crank_angle(2, t)
    assert np.max(np.abs(run.q("crank_0.phi") - exact) / (1.0 + np.abs(exact))) <= 1e-6
