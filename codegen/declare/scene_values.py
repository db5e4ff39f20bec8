"""Elements, start values and parameters that a scene names; unknown names get a hint."""

from collections.abc import Iterable, Mapping
from typing import Any

import sympy

from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.declare.names import nearest
from codegen.declare.parameter import ParameterDeclaration
from codegen.declare.symbols import Coordinate
from codegen.declare.value_reader import Reader

Names = Iterable["str | Body | Constraint | Effect"]
Values = Mapping["str | sympy.Symbol", Any]
NamedValues = tuple[tuple[str, float], ...]


def named(
    read: Reader, where: str, kind: str, names: Names, known: Mapping[str, Any]
) -> tuple[str, ...]:
    """The known elements among `names`, in the order of their declaration."""
    chosen = []
    for item in (names,) if isinstance(names, str) else names:
        name = item if isinstance(item, str) else item.name
        if name in known:
            chosen.append(name)
        else:
            read.problems.append(f"{where}: no {kind} '{name}'; {nearest(name, known)}")
    return tuple(name for name in known if name in chosen)


def states(
    read: Reader, where: str, coordinates: Iterable[Coordinate], values: Values
) -> tuple[tuple[str, float], ...]:
    """Values of coordinates and velocities (``"crank.phi"``, or the symbol) in SI units."""
    known: dict[str, str] = {}
    for q in coordinates:
        known |= {dotted(q): q.unit, dotted(q.rate): q.measure.rate_unit}
    read_values = {}
    for key, value in values.items():
        name = key if isinstance(key, str) else dotted(key)
        if name in known:
            read_values[name] = read.finite(value, known[name], f"{where}, {name}")
        else:
            hint = nearest(name, known)
            read.problems.append(f"{where}: '{name}' is no coordinate or velocity; {hint}")
    return tuple(read_values.items())


def dotted(symbol: sympy.Symbol) -> str:
    """``crank_phi`` → ``crank.phi``."""
    return ".".join(symbol.name.rsplit("_", 1))


def overrides(
    read: Reader, where: str, parameters: Mapping[str, ParameterDeclaration], values: Values
) -> tuple[tuple[str, float], ...]:
    """Values of parameters in their declared units."""
    read_values = {}
    for key, value in values.items():
        name = key if isinstance(key, str) else key.name
        if name in parameters:
            unit = parameters[name].unit
            read_values[name] = read.number(value, unit, f"{where}, parameter '{name}'")
        else:
            read.problems.append(f"{where}: no parameter '{name}'; {nearest(name, parameters)}")
    return tuple(read_values.items())
