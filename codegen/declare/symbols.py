"""The symbols that a declaration is written in, told apart by class instead of by name."""

from typing import Any

import sympy

RATES = {"x": "vx", "y": "vy", "phi": "omega", "alpha": "alphadot", "beta": "betadot"}
"""Letter of a coordinate → letter of its velocity; α and β are contact parameters of elements."""

LENGTHS = ("x", "y")


class Coordinate(sympy.Symbol):  # type: ignore[misc]
    """A generalized coordinate; `rate` is its velocity."""

    @property
    def unit(self) -> str:
        """``"m"`` for positions, ``"rad"`` for angles and the parameters of curves."""
        return "m" if self.name.rpartition("_")[2] in LENGTHS else "rad"

    @property
    def rate(self) -> "Velocity":
        """The velocity symbol that belongs to this coordinate (``crank_phi`` → ``crank_omega``)."""
        owner, _, letter = self.name.rpartition("_")
        return Velocity(f"{owner}_{RATES[letter]}", real=True)


class Velocity(sympy.Symbol):  # type: ignore[misc]
    """The time derivative of a generalized coordinate; `coordinate` is that coordinate."""

    @property
    def coordinate(self) -> Coordinate:
        """The coordinate whose rate this is (``crank_omega`` → ``crank_phi``)."""
        owner, _, letter = self.name.rpartition("_")
        (place,) = (place for place, speed in RATES.items() if speed == letter)
        return Coordinate(f"{owner}_{place}", real=True)


class Acceleration(sympy.Symbol):  # type: ignore[misc]
    """The second time derivative of a coordinate; occurs in rates of switching functions."""


class Multiplier(sympy.Symbol):  # type: ignore[misc]
    """A Lagrange multiplier."""


class Time(sympy.Symbol):  # type: ignore[misc]
    """The time, in seconds."""


class Side(sympy.Symbol):  # type: ignore[misc]
    """A number that says on which side of its surface an effect acts; its mode decides."""


class Speed(sympy.Symbol):  # type: ignore[misc]
    """The rate ṡ of the scalar along which a force acts."""


class Given(sympy.Symbol):  # type: ignore[misc]
    """A placeholder in an element's own equations, bound to a number or parameter in a model."""


class Parameter(sympy.Symbol):  # type: ignore[misc]
    """A number that may change between runs without a new build."""


t = Time("t", real=True)

SPEED = Speed("s_rate", real=True)
"""ṡ, in which a force along a scalar s is written: f = k s + c ṡ."""

alpha = Given("alpha", real=True)
"""The parameter in which the profile of a cam is written, rad."""


def coordinate(owner: str, letter: str) -> Coordinate:
    """Coordinate `letter` (``x``, ``y``, ``phi``; ``alpha``, ``beta``) of the body or element."""
    return Coordinate(f"{owner}_{letter}", real=True)


def side(name: str) -> Side:
    """The side on which the effect of that name acts, as its `Sticking` or `Rigid` says."""
    return Side(f"{name}_side", real=True)


def given(name: str) -> Given:
    """Placeholder called `name` for a real number."""
    return Given(name, real=True)


def kinds(expression: sympy.Basic, *classes: type[Any]) -> list[Any]:
    """Symbols of the given classes in an expression, in the order of their names."""
    found = [s for s in expression.free_symbols if isinstance(s, classes)]
    return sorted(found, key=lambda s: s.name)
