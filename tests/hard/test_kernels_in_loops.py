"""A few hard cases with kernels in loops over tables, as large machines have them."""

from collections.abc import Iterator

import pytest

from models.hard.cases import find
from models.hard.suite.cell import COMPARED, Setting, Verdict, run
from tests.unrolling import built_with

CASES = ("n_four_bar_2", "five_bar_even", "ball_dropped", "belt_block", "law_with_jumps")
"""Crossings, a branch, impacts, friction that sticks, and a function of time."""


@pytest.fixture(scope="module", autouse=True)
def in_loops(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with built_with("never", tmp_path_factory.mktemp("generated")):
        yield


@pytest.mark.parametrize("name", CASES)
def test_a_case_is_right_with_kernels_in_loops(name: str) -> None:
    case = find(name)
    cell = run(case, Setting(COMPARED, "step"), 1e-9)
    assert cell.verdict in {Verdict.CORRECT, Verdict.EXPECTED}, cell.note
    path = case.machine().path
    assert path.parent.name.startswith("generated")
    assert "--unroll never" in path.read_text(encoding="utf-8")[:4000]
