"""Bodies repeated and turns peeled, so that what a loop reads stands on straight lines."""

import numpy as np
import pytest

from codegen.reroll.affine_accesses import with_affine_accesses
from codegen.reroll.repetition import Stretch
from codegen.reroll.rerolling import reroll
from tests.codegen.reroll.machines import lowered, rolled_text

LOOP = Stretch(100, 3, 40)


def column(addresses: object) -> tuple[np.ndarray, np.ndarray]:
    """One kind of place at these addresses."""
    return np.zeros(LOOP.turns, dtype=np.int64), np.array(addresses)


def test_a_loop_on_straight_lines_stays_as_it_is() -> None:
    turns = np.arange(LOOP.turns)
    assert with_affine_accesses(LOOP, [column(7 * turns), column(500 - 2 * turns)]) == [LOOP]
    assert with_affine_accesses(LOOP, []) == [LOOP]


def test_a_body_is_repeated_where_every_other_turn_reads_at_another_distance() -> None:
    turns = np.arange(LOOP.turns)
    zigzag = column(10 * turns + 4 * (turns % 2))
    assert with_affine_accesses(LOOP, [zigzag]) == [Stretch(100, 6, 20)]


def test_first_and_last_turns_are_peeled_where_they_read_elsewhere() -> None:
    addresses = 10 * np.arange(LOOP.turns)
    addresses[0], addresses[-1] = 999, -5
    found = with_affine_accesses(LOOP, [column(addresses)])
    assert found == [Stretch(100, 3, 1), Stretch(103, 3, 38), Stretch(217, 3, 1)]


def test_another_kind_of_place_is_no_straight_line() -> None:
    kinds, addresses = column(10 * np.arange(LOOP.turns))
    kinds[-1] = 1
    assert with_affine_accesses(LOOP, [(kinds, addresses)])[-1] == Stretch(217, 3, 1)


def test_a_table_stays_where_the_text_without_it_is_longer() -> None:
    irregular = column(np.random.default_rng(5).integers(0, 1000, LOOP.turns))
    assert with_affine_accesses(LOOP, [irregular]) == [LOOP]


@pytest.mark.parametrize("family", ["chain", "n_four_bar"])
def test_accelerations_of_a_row_read_one_table_that_of_the_checks(family: str) -> None:
    machine = lowered(family, 60)
    text = rolled_text(machine, machine.kernels["accelerations"], reroll)
    *others, checks = (table for table in text.tables if table.columns)
    assert len(checks.columns) == 3
    assert sum(len(table.columns) for table in others) <= 1
