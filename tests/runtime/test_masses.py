"""Masses that parameter values make impossible: who is refused, and what the question costs."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from codegen.errors import ParameterError
from runtime.mechanism.table_rows import Coordinate
from runtime.validation import arguments

GIVEN = "Given are rho = -2 kg/m: give other values."


class Counted(tuple[Coordinate, ...]):
    """Rows that count how many of them are looked at."""

    looked = 0

    def __getitem__(self, index: Any) -> Any:
        Counted.looked += 1
        return super().__getitem__(index)

    def __iter__(self) -> Any:
        for row in super().__iter__():
            Counted.looked += 1
            yield row


def machine_of(bodies: int) -> Any:
    kinds = (("x", "vx", "m"), ("y", "vy", "m"), ("phi", "omega", "rad"))
    rows = Counted(
        Coordinate(f"b{k}.{q}", f"b{k}.{v}", unit) for k in range(bodies) for q, v, unit in kinds
    )
    told = SimpleNamespace(
        title="m/s", bodies=tuple(f"b{k}" for k in range(bodies)), coordinates=rows, neutral=None,
        parameters=(SimpleNamespace(name="rho", unit="kg/m", default=1.0),),
    )  # fmt: skip
    return SimpleNamespace(description=told, coordinates=rows)


@pytest.fixture
def of(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Diagonals of M in place of a machine's."""

    def given(diagonal: np.ndarray) -> None:
        equations = SimpleNamespace(masses=lambda q: diagonal)
        monkeypatch.setattr(arguments, "Equations", lambda machine, p: equations)

    return given


def test_each_impossible_mass_and_inertia_is_refused_by_its_body(of: Any) -> None:
    diagonal = np.ones(9)
    diagonal[[3, 4]], diagonal[5], diagonal[8] = -2.0, 0.0, np.nan
    of(diagonal)
    with pytest.raises(ParameterError) as caught:
        arguments.require_masses(machine_of(3), np.array([-2.0]))
    assert caught.value.problems == (
        f"m/s: the mass of b1 is -2 kg; it must be a positive finite number. {GIVEN}",
        f"m/s: the inertia of b1 is 0 kg m^2; it must be a positive finite number. {GIVEN}",
        f"m/s: the inertia of b2 is nan kg m^2; it must be a positive finite number. {GIVEN}",
    )


@pytest.mark.parametrize("mass", [1.0, 0.0])
def test_rows_of_a_large_machine_are_looked_at_once(of: Any, mass: float) -> None:
    count = 200
    of(np.full(3 * count, mass))
    made = machine_of(count)
    Counted.looked = 0
    if mass:
        arguments.require_masses(made, np.array([-2.0]))
    else:
        with pytest.raises(ParameterError) as caught:
            arguments.require_masses(made, np.array([-2.0]))
        assert len(caught.value.problems) == 2 * count
    assert Counted.looked <= 3 * count
