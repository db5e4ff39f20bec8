"""Rows of tables, and outcomes, found by what a user gives: by a name or number, or an error."""

import pickle
from typing import Any

import numpy as np
import pytest

from codegen.errors import InputError, LinkwrightError, UnknownNameError
from runtime import Outcome
from runtime.mechanism.table_rows import Coordinate, Table

ROWS: Table[Coordinate] = Table([Coordinate("a.x", "a.vx", "m"), Coordinate("a.y", "a.vy", "m")])


ODD = [None, 1.0, 99, [0], "z", b"a.x", float("nan")]


@pytest.mark.parametrize("odd", ODD)
def test_a_row_that_is_none_is_refused(odd: Any) -> None:
    assert odd not in ROWS
    with pytest.raises(UnknownNameError, match=r"There is no (row|name) .*there are: a\.x, a\.y"):
        ROWS[odd]
    with pytest.raises(UnknownNameError, match="There is no name"):
        ROWS.index(odd)


def test_rows_are_found_by_name_position_and_as_themselves() -> None:
    assert ROWS["a.y"] is ROWS[1] is ROWS[np.int64(-1)] is ROWS[ROWS[1]]  # type: ignore[index]
    assert ROWS[:1] == (ROWS[0],)
    assert "a.x" in ROWS
    assert ROWS[0] in ROWS


@pytest.mark.parametrize("given", [None, 99, -1, 1.5, "OK"])
def test_no_outcome_is_made_of_what_is_none(given: Any) -> None:
    with pytest.raises(InputError, match=r"Outcome\(.*number of an outcome, 0 to 15"):
        Outcome(given)


def test_outcomes_are_found_by_number() -> None:
    assert Outcome(3) is Outcome(np.int64(3)) is pickle.loads(pickle.dumps(Outcome(3)))
    assert issubclass(InputError, LinkwrightError)
