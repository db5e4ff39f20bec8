"""Rows of tables, and outcomes, found by what a user gives: by a name or number, or an error."""

import pickle
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

from codegen.errors import InputError, LinkwrightError, UnknownNameError
from runtime import Outcome
from runtime.mechanism.table_rows import Coordinate, Table

ROWS: Table[Coordinate] = Table([Coordinate("a.x", "a.vx", "m"), Coordinate("a.y", "a.vy", "m")])


class Hidden:
    """An object whose class is not to be had."""

    @property  # type: ignore[misc]
    def __class__(self) -> Any:
        raise GeneratorExit


class Incomparable:
    """An object whose comparison fails."""

    def __eq__(self, other: object) -> bool:
        raise SystemExit

    __hash__ = None  # type: ignore[assignment]


class OddText(str):
    """A text whose comparison fails."""

    __slots__ = ()
    __eq__ = Incomparable.__eq__
    __hash__ = str.__hash__


ODD = [None, Hidden(), Incomparable(), Mock(spec=str), 1.0, 99, [0], "z", b"a.x", float("nan")]


@pytest.mark.parametrize("kind", range(len(ODD)))
def test_a_row_that_is_none_is_refused(kind: int) -> None:
    odd = ODD[kind]
    assert odd not in ROWS
    with pytest.raises(UnknownNameError, match=r"There is no (row|name) .*there are: a\.x, a\.y"):
        ROWS[odd]
    with pytest.raises(UnknownNameError, match="There is no name"):
        ROWS.index(odd)


def test_rows_are_found_by_name_position_and_as_themselves() -> None:
    assert ROWS["a.y"] is ROWS[1] is ROWS[np.int64(-1)] is ROWS[ROWS[1]]  # type: ignore[index]
    assert ROWS[OddText("a.y")] is ROWS[1]
    assert OddText("a.x") in ROWS
    assert ROWS[:1] == (ROWS[0],)
    assert "a.x" in ROWS
    assert ROWS[0] in ROWS


@pytest.mark.parametrize(
    ("given", "words"),
    [((None,), {}), ((99,), {}), ((True,), {}), ((1.0,), {}), ((1,), {"names": "a"}), ((), {})],
)
def test_no_outcome_is_made_of_what_is_none(given: tuple[Any, ...], words: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"Outcome\(.*number"):
        Outcome(*given, **words)


def test_outcomes_are_found_by_number() -> None:
    assert Outcome(3) is Outcome(np.int64(3)) is pickle.loads(pickle.dumps(Outcome(3)))
    assert issubclass(InputError, LinkwrightError)
