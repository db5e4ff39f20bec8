"""Runs of machines with many coordinates, whose Jacobian is never a dense matrix."""

import numpy as np
import pytest

from runtime.integrate import wiring
from runtime.linalg.least_norm import SPARSE_FROM
from runtime.machine_facade import Machine
from runtime.mechanism import dense_equations
from runtime.singularity import scaled_constraints
from tests.runtime import bars

SPARSE, DENSE = 0, 10**9


def set_threshold(monkeypatch: pytest.MonkeyPatch, threshold: int) -> None:
    for module in (wiring, dense_equations, scaled_constraints):
        monkeypatch.setattr(module, "SPARSE_FROM", threshold)
    wiring._lay_out.cache_clear()


def numbers_held(machine: Machine) -> int:
    """Numbers in the arrays of a run."""
    p = np.zeros(0)
    return int(wiring.wire(machine.mechanism.system, "dop853", p, 8).block.size)


@pytest.mark.parametrize(
    ("machine", "t_end", "name"),
    [(bars.chain(20), 0.7, "link_19.phi"), (bars.n_four_bar(8), 3.0, "crank_8.phi")],
    ids=["chain", "loops"],
)
def test_sparse_and_dense_runs_agree(
    machine: Machine, t_end: float, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for threshold in (DENSE, SPARSE):
        set_threshold(monkeypatch, threshold)
        machine.mechanism.starts.clear()
        found.append(machine.simulate(t_end, rtol=1e-9))
    dense, sparse = found
    assert sparse.q(name) == pytest.approx(dense.q(name), abs=1e-6)
    assert sparse.stats["singular_crossings"] == dense.stats["singular_crossings"]
    assert sparse.stats["steps"] <= 1.1 * dense.stats["steps"]
    assert sparse.stats["repartitions"] <= dense.stats["repartitions"] + 2


def test_independent_coordinates_determine_the_others_well(monkeypatch: pytest.MonkeyPatch) -> None:
    set_threshold(monkeypatch, SPARSE)
    run = bars.chain(30).simulate(1.0, rtol=1e-7)
    assert all(len(chosen.independent) == 30 for chosen in run.partitions)
    assert run.stats["repartitions"] < 10


@pytest.mark.parametrize("family", [bars.chain, bars.n_four_bar])
def test_numbers_held_by_a_run_grow_linearly(family: object) -> None:
    first, second = (
        numbers_held(family(count))
        for count in (SPARSE_FROM, 2 * SPARSE_FROM)  # type: ignore[operator]
    )
    assert second < 2.05 * first
