"""Counts of the work of declaring and checking a machine grow no faster than the machine."""

import pytest

from codegen import plain_values, public_callables
from codegen.declare.return_values import calls
from codegen.declare.return_values.calls import memoize_methods
from codegen.declare.symbols import Coordinate, ModelSymbol
from codegen.driver import valid_scenes
from models.hard.n_four_bar import n_four_bar


def values_read(monkeypatch: pytest.MonkeyPatch, loops: int) -> int:
    """Values, and members of values, that are read while a row of four-bars is declared."""
    count, genuine = [0], plain_values.genuine

    def counted(value: object, depth: int = 3) -> object:
        count[0] += 1
        return genuine(value, depth)

    with monkeypatch.context() as patch:
        for module in (plain_values, public_callables, calls):
            patch.setattr(module, "genuine", counted)
        memoize_methods(valid_scenes)(n_four_bar(loops), "fall")
    return count[0]


def test_values_are_read_once_a_joint(monkeypatch: pytest.MonkeyPatch) -> None:
    """No joint without coordinates of its own reads the start values of all others."""
    few, many = (values_read(monkeypatch, loops) for loops in (10, 40))
    assert 2 * few < many < 4 * few, (few, many)


def test_the_symbols_of_a_large_machine_are_made_once() -> None:
    """SymPy keeps a thousand symbols; a machine with more gets each of its own again."""
    bodies = [*n_four_bar(200).bodies.values()]
    asked = [symbol for body in bodies for q in body.coordinates for symbol in (q, q.rate)]
    again = [symbol for body in bodies for q in body.coordinates for symbol in (q, q.rate)]
    assert len(asked) == 2406
    assert all(a is b for a, b in zip(asked, again, strict=True))
    assert isinstance(asked[0], Coordinate)
    assert all(isinstance(symbol, ModelSymbol) for symbol in asked)
