"""Counts of the work of declaring and checking a machine grow no faster than the machine."""

from collections import Counter
from typing import Any

import pytest
import sympy

from codegen.check import elements, potential_steps
from codegen.declare.returned_values import memoize_methods
from codegen.declare.symbols import Coordinate, ModelSymbol
from codegen.elements.joints.points import Revolute
from codegen.reading.scene_selection import valid_scenes
from models.hard.n_four_bar import n_four_bar


def test_the_symbols_of_a_large_machine_are_made_once() -> None:
    """SymPy keeps a thousand symbols; a machine with more gets each of its own again."""
    bodies = [*n_four_bar(200).bodies.values()]
    asked = [symbol for body in bodies for q in body.coordinates for symbol in (q, q.rate)]
    again = [symbol for body in bodies for q in body.coordinates for symbol in (q, q.rate)]
    assert len(asked) == 2406
    assert all(a is b for a, b in zip(asked, again, strict=True))
    assert isinstance(asked[0], Coordinate)
    assert all(isinstance(symbol, ModelSymbol) for symbol in asked)


def test_a_joint_states_its_equations_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Once for all checks of the machine; its scenes name coordinates of bodies alone."""
    asked = Counter[str]()

    def counted(joint: Any) -> Any:
        asked[joint.name] += 1
        return stated(joint)

    stated = Revolute.statement
    monkeypatch.setattr(Revolute, "statement", counted)
    model = n_four_bar(5)
    memoize_methods(valid_scenes)(model, "fall")
    assert {*asked.values()} == {1}


def test_equations_that_joints_share_are_checked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The sums that are looked through do not grow with the number of revolute joints."""
    seen, find = [0], elements.distinct_nodes

    def counted(expression: sympy.Basic) -> list[sympy.Basic]:
        seen[0] += expression.is_Add
        return find(expression)

    monkeypatch.setattr(elements, "distinct_nodes", counted)
    counts = []
    for loops in (5, 10):
        elements._flaws.cache_clear()
        seen[0] = 0
        memoize_methods(valid_scenes)(n_four_bar(loops), "fall")
        counts.append(seen[0])
    assert 0 < counts[0] == counts[1], counts


def test_a_smooth_potential_is_not_compiled_for_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """That of gravity on all bodies has no surface, on whose sides it could be compared."""
    compiled: list[sympy.Basic] = []
    monkeypatch.setattr(potential_steps, "plain_function", lambda symbols, e: compiled.append(e))
    memoize_methods(valid_scenes)(n_four_bar(3), "fall")
    assert compiled == []
