"""Bodies repeated and turns peeled, so that what a loop reads stands on straight lines."""

import numpy as np
import pytest

from codegen.reroll.rerolling import reroll, with_affine_accesses
from codegen.reroll.sequence import Stretch
from tests.codegen.reroll.machines import lowered, rolled_text

LOOP = Stretch(100, 3, 40)
TURNS = np.arange(LOOP.turns)
PLACES = np.zeros(LOOP.turns, dtype=np.int64)  # all of one kind
ELSEWHERE = 10 * TURNS
ELSEWHERE[[0, -1]] = 999, -5


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ([(PLACES, 7 * TURNS), (PLACES, 500 - 2 * TURNS)], [LOOP]),  # straight lines
        ([], [LOOP]),
        # Every other turn reads at another distance, the first and the last elsewhere, or from
        # another kind of place; or the text without the table is longer.
        ([(PLACES, 10 * TURNS + 4 * (TURNS % 2))], [(100, 6, 20)]),
        ([(PLACES, ELSEWHERE)], [(100, 3, 1), (103, 3, 38), (217, 3, 1)]),
        ([(PLACES + (TURNS[-1] == TURNS), 10 * TURNS)], [(100, 3, 39), (217, 3, 1)]),
        ([(PLACES, np.random.default_rng(5).integers(0, 1000, LOOP.turns))], [LOOP]),
    ],
)
def test_a_loop_becomes_one_on_straight_lines_and_turns_beside_it(
    columns: list[tuple[np.ndarray, np.ndarray]], expected: list[tuple[int, int, int]]
) -> None:
    assert with_affine_accesses(LOOP, columns) == expected


@pytest.mark.parametrize("family", ["chain", "n_four_bar"])
def test_accelerations_of_a_row_read_one_table_that_of_the_checks(family: str) -> None:
    machine = lowered(family, 60)
    text = rolled_text(machine, machine.kernels["accelerations"], reroll)
    *others, checks = (table for table in text.tables if table.columns)
    assert len(checks.columns) == 3
    assert sum(len(table.columns) for table in others) <= 1
