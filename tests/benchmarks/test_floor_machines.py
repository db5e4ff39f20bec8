"""The floors of Andrews' mechanism and of the chain: their references, and ours beside them."""

import math
from pathlib import Path

import numpy as np
import pytest

from benchmarks import linkwright_runs
from benchmarks.floor import andrews, chain
from benchmarks.floor.arithmetic import in_terms_of
from benchmarks.growth import hanging
from benchmarks.operation_counts import cost
from benchmarks.problems import ANDREWS, PROBLEMS, crank_of_loops
from codegen import build
from codegen.files.generated_modules import companion_path, import_generated
from models.hard.n_four_bar import n_four_bar

STARTED = 14222.4439199541138705911625887
"""β'' at the start, rad/s², as the Test Set for IVP Solvers prints it."""


def rows(root: Path, name: str) -> np.ndarray:
    return np.loadtxt(root / "tests" / "data" / name, delimiter=",", skiprows=1, comments="#")


def test_both_equations_of_the_squeezer_start_as_published() -> None:
    _, with_angles, *_ = andrews.with_angles(*andrews.START, andrews.TORQUE)
    _, closed = andrews.in_closed_form(*andrews.START[:2], andrews.TORQUE)
    assert with_angles == pytest.approx(STARTED, rel=1e-13)
    assert closed == pytest.approx(STARTED, rel=1e-13)


def test_both_equations_of_the_squeezer_come_where_they_must() -> None:
    for answer in (andrews.answer, andrews.answer_closed):
        angle, steps, rejected = answer(1e-12)
        assert ANDREWS.error([angle]) < 2e-10
        assert rejected < 0.2 * steps


def test_the_squeezer_of_the_other_benchmark(root: Path) -> None:
    """From β = -0.0620 over 0.05 s, against the independent reference."""
    last = rows(root, "andrews.csv")[-1]
    beta, *_ = andrews.run_closed(-0.062, 0.0, 0.0, last[0], 1e-5, 1e-13, andrews.TORQUE)
    assert last[0] == 0.05
    assert beta == pytest.approx(last[1], abs=1e-9)


@pytest.mark.parametrize("links", [1, 2, 4])
def test_the_chain_is_that_of_a_dense_solution(links: int) -> None:
    angles, steps, rejected = chain.answer(links, 1e-12)
    assert np.allclose(angles, hanging(links), rtol=0.0, atol=1e-9)
    assert rejected < 0.2 * steps


def test_an_equation_in_another_arithmetic_is_the_same() -> None:
    plain = in_terms_of(andrews.in_closed_form, math)
    state = (0.7, 300.0)
    assert plain(*state, andrews.TORQUE) == pytest.approx(
        andrews.in_closed_form(*state, andrews.TORQUE), rel=1e-13
    )


@pytest.mark.parametrize("loops", [2, 10])
def test_the_four_bars_follow_an_elliptic_function(root: Path, loops: int) -> None:
    table = rows(root, f"n_four_bar_{loops}.csv")
    found = [crank_of_loops(loops, t) for t in table[:, 0]]
    assert np.allclose(found, table[:, 1], rtol=0.0, atol=1e-10)


@pytest.fixture(scope="module")
def folder(request: pytest.FixtureRequest) -> Path:
    """A folder whose compiled scenes outlive a run."""
    made: Path = request.config.cache.mkdir("floor-machines")
    return made


@pytest.mark.parametrize("name", ["slider_crank", "andrews"])
@pytest.mark.parametrize("formulation", linkwright_runs.FORMULATIONS)
def test_ours_come_where_the_floors_do(name: str, formulation: str, folder: Path) -> None:
    entry = linkwright_runs.ENTRIES[name]
    run, took = linkwright_runs.simulated(
        entry, linkwright_runs.machine_of(entry, folder), formulation, 1e-12
    )
    angle = float(run.q(entry.angles[0])[-1])
    ((_, floor), *_) = entry.floors
    assert not run.failed
    assert took > 0.0
    assert PROBLEMS[name].error([angle]) < 2e-8
    assert angle == pytest.approx(floor(1e-12)[0][0], abs=2e-8)


def test_the_squeezer_needs_few_operations_more_than_by_hand(folder: Path) -> None:
    """One call of ours solves the loops and answers all accelerations."""
    machine = linkwright_runs.machine_of(linkwright_runs.ANDREWS, folder)
    assert machine.mechanism.reduced.closures == ()
    counts = dict(import_generated(companion_path(machine.path, "reduced")).OPERATIONS)
    assert 0 < counts["accelerations"] < 2.0 * cost(andrews.equation)


def test_operations_grow_linearly_with_the_loops(tmp_path: Path) -> None:
    counted = []
    for loops in (2, 3, 4):
        (made,) = build(n_four_bar(loops), "fall", tmp_path, compile=False).scenes
        counted.append(made.operations["accelerations"])
    first, second = np.diff(counted)
    assert second <= 1.1 * first
