"""Values and names in a declaration → SymPy expressions in SI units, and names that are known.

Problems are collected, one sentence each; unknown names get a hint.
"""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import sympy
from sympy.core.relational import Relational

from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.declare.name_rules_and_hints import nearest
from codegen.declare.symbols import Coordinate, ParameterDeclaration
from codegen.declare.units import expression, in_unit

Names = Iterable["str | Body | Constraint | Effect"]
Values = Mapping["str | sympy.Symbol", Any]
NamedValues = tuple[tuple[str, float], ...]


def name_of(element: Any) -> str:
    """The name of an element that is given by its name or as an object."""
    return str(getattr(element, "name", element))


def dotted(symbol: sympy.Symbol) -> str:
    """``crank_phi`` → ``crank.phi``."""
    return ".".join(symbol.name.rsplit("_", 1))


class Reader:
    """Reads values, and notes a sentence about each that cannot be read."""

    def __init__(self) -> None:
        self.problems: list[str] = []  # the sentences, in order

    def note(self, problem: str) -> None:
        """Add a problem."""
        self.problems.append(problem)

    def value(self, value: Any, unit: str, where: str) -> Any:
        """A number, quantity or expression in `unit`; 1 stands in for one that is noted."""
        if value is None:
            self.note(f"{where} is missing; give it{f' in {unit}' if unit else ''}.")
            return sympy.S.One
        try:
            return expression(in_unit(value, unit, where, self.problems))
        except (TypeError, sympy.SympifyError) as why:
            unit = f", for {why}; give a quantity of pint" if "unit of SymPy" in str(why) else ""
            self.note(f"{where}: {value!r} is neither a number nor an expression{unit}.")
            return sympy.S.One

    def pair(
        self, value: Any, unit: str, where: str, like: str = "two values, (1, 0)"
    ) -> tuple[Any, Any]:
        """Two values; anything else is noted as a problem and read as (1, 0)."""
        try:
            first, second = value
        except (TypeError, ValueError):
            self.note(f"{where}: {value!r} is no pair; write {like}.")
            first, second = 1, 0
        return self.value(first, unit, where), self.value(second, unit, where)

    def axis(self, value: Any, name: str) -> tuple[sympy.Expr, sympy.Expr]:
        """The components of an axis, m; anything but a pair is noted and read as (1, 0)."""
        return self.pair(value, "m", f"axis of '{name}'", "axis=(1, 0)")

    def gated(self, value: Any, unit: str, where: str, when: Any) -> Any:
        """A value while the condition `when` holds, else zero; None holds always."""
        force = self.value(value, unit, where)
        if when is None:
            return force
        if not isinstance(when, Relational | sympy.And | sympy.Or | sympy.Not):
            reason = "never changes" if str(when) in ("True", "False") else "is no condition"
            self.note(
                f"{where}: when={when!r} {reason}; compare coordinates, velocities, parameters or "
                "t by <, <=, > or >=, joined by And, Or and Not, or leave it out."
            )
            return force
        return sympy.S.Zero if force == 0 else sympy.Piecewise((force, when), (0, True))

    def number(self, value: Any, unit: str, where: str) -> float:
        """A plain number in `unit`."""
        try:
            return float(in_unit(value, unit, where, self.problems))
        except (TypeError, ValueError, OverflowError):
            self.note(f"{where}: {value!r} is not a number.")
            return 1.0

    def finite(self, value: Any, unit: str, where: str) -> float:
        """A plain number that is neither infinite nor undefined."""
        number = self.number(value, unit, where)
        if math.isfinite(number):
            return number
        self.note(f"{where}: the value is {number}; give a finite number.")
        return 0.0

    def choice(self, value: Any, allowed: tuple[str, ...], where: str) -> Any:
        """One of a few words."""
        if value in allowed:
            return value
        self.note(f"{where}: {value!r} is none of {', '.join(map(repr, allowed))}.")
        return allowed[0]

    def mapping(self, value: Any, word: str, like: str, where: str) -> Mapping[Any, Any]:
        """The mapping that the keyword `word` takes; None, and anything else, is read as empty."""
        if value is None or isinstance(value, Mapping):
            return value or {}
        self.note(f"{where}: {word}={value!r} is no mapping; write {like}.")
        return {}

    def elements(
        self, names: Names, known: Mapping[str, Any], kind: str, where: str
    ) -> tuple[str, ...]:
        """The known elements among `names`, in the order of their declaration."""
        chosen = [name_of(e) for e in ((names,) if isinstance(names, str) else names)]
        for name in (n for n in chosen if n not in known):
            self.note(f"{where}: no {kind} '{name}'; {nearest(name, known)}")
        return tuple(name for name in known if name in chosen)

    def states(self, values: Values, coordinates: Iterable[Coordinate], where: str) -> NamedValues:
        """Values of coordinates and velocities (``"crank.phi"``, or the symbol) in SI units."""
        units: dict[str, str] = {}
        for q in coordinates:
            units |= {dotted(q): q.unit, dotted(q.rate): q.measure.rate_unit}
        numbers = {}
        for key, value in values.items():
            name = key if isinstance(key, str) else dotted(key)
            if name in units:
                numbers[name] = self.finite(value, units[name], f"{where}, {name}")
            else:
                hint = nearest(name, units)
                self.note(f"{where}: '{name}' is no coordinate or velocity; {hint}")
        return tuple(numbers.items())

    def overrides(
        self, values: Values, parameters: Mapping[str, ParameterDeclaration], where: str
    ) -> NamedValues:
        """Values of parameters in their declared units."""
        numbers = {}
        for name, value in ((name_of(key), value) for key, value in values.items()):
            if name in parameters:
                unit = parameters[name].unit
                numbers[name] = self.number(value, unit, f"{where}, parameter '{name}'")
            else:
                self.note(f"{where}: no parameter '{name}'; {nearest(name, parameters)}")
        return tuple(numbers.items())
