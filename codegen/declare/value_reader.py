"""Readers of a modeller's input, by its kind; all problems are collected and reported at once.

Scalar, pair, vector, number, condition, word, flag, mapping, names: each kind has one method of
`Reader`. It returns plain numbers, SymPy expressions in SI units and text; what is of another kind
is noted, one sentence each, and a value of the kind stands in for it. `expression_problem` says
what an expression may consist of, wherever it stands in a declaration.
"""

from collections.abc import Callable, Iterable, Mapping
from inspect import isfunction
from math import isfinite
from typing import Any

import sympy
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean

from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.declare.rotation_entries import ENTRIES
from codegen.declare.scene import name_of
from codegen.declare.symbols import (
    Acceleration,
    Coordinate,
    Given,
    Multiplier,
    Parameter,
    ParameterDeclaration,
    Side,
    Speed,
    Time,
    Velocity,
    alpha,
    kinds,
)
from codegen.readers.calls import failure, unreadable
from codegen.readers.expressions import UNFINISHED, distinct_nodes, plain_expression, unreal_part
from codegen.readers.quantities import UnitError, in_unit
from codegen.readers.values import (
    KindError,
    entries,
    is_flag,
    members,
    nearest,
    nearest_quantity,
    one_line,
    plain_float,
    shown,
)
from codegen.tables.piecewise_function import ClosedPieces, PiecesAtom
from codegen.tables.table_function import Interpolant, TableAtom

INTERNAL = (Given, Side, Speed, Multiplier, Acceleration)
"""Symbols of the equations of elements, which mean nothing in a declaration."""
FUNCTIONS = (
    *(Interpolant, ClosedPieces),
    *(sympy.Piecewise, sympy.Abs, sympy.Heaviside, sympy.Max, sympy.Min, sympy.sign),
    *(sympy.sin, sympy.cos, sympy.tan, sympy.asin, sympy.acos, sympy.atan, sympy.atan2),
    *(sympy.sinh, sympy.cosh, sympy.tanh, sympy.exp, sympy.log),
    *(sympy.floor, sympy.ceiling, sympy.Mod),
)
"""The functions that can be compiled."""
PLAIN = (
    *(sympy.Symbol, sympy.Number, sympy.NumberSymbol, sympy.Add, sympy.Mul, sympy.Pow),
    *(TableAtom, PiecesAtom, *ENTRIES),
    *(sympy.I.func, sympy.zoo.func, Relational, Boolean, sympy.Tuple, *UNFINISHED),
)
"""What needs no function, or is refused for a reason of its own."""
MEANINGFUL = (Coordinate, Velocity, Time, Parameter)
"""Symbols that mean something in a declaration."""


def expression_problem(expression: sympy.Expr, profile: bool = False) -> str | None:
    """Why an expression can stand nowhere in a declaration; a `profile` may contain `alpha`."""
    if isinstance(expression, MEANINGFUL):
        return None
    try:
        return _problem(expression, profile)
    except Exception as error:  # of SymPy, of an expression too deep
        return unreadable(error)


def _problem(expression: sympy.Expr, profile: bool) -> str | None:
    for symbol in sorted(expression.free_symbols, key=str):
        if symbol == alpha and not profile:
            return (
                f"{one_line(expression)} contains alpha, the parameter of a profile, which means "
                "nothing outside of body.curve(...) and body.polar(...); a cam's contact is at "
                "joint.alpha."
            )
        if isinstance(symbol, INTERNAL) and symbol != alpha:
            return (
                f"{one_line(expression)} contains '{one_line(symbol)}', a placeholder of an "
                "element's equations; use coordinates, velocities, parameters and t."
            )
    return compile_problem(expression)


def compile_problem(expression: sympy.Basic) -> str | None:
    """Why an expression has no value, or cannot be compiled; None: it can."""
    found = unreal_part(expression)
    unknown = [
        node
        for node in distinct_nodes(expression)
        if node.func not in FUNCTIONS and not isinstance(node, PLAIN) and not node.is_number
    ]
    if unknown:
        known = ", ".join(sorted(f.__name__ for f in FUNCTIONS[3:]))
        what = min(map(one_line, unknown))
        return f"{what} cannot be compiled; known are {known}, powers and Piecewise."
    pieces = expression.atoms(sympy.Piecewise)
    incomplete = [piece for piece in pieces if piece.args[-1].cond != sympy.true]
    if incomplete:
        return (
            f"{one_line(min(incomplete, key=str))} says nothing where none of its conditions "
            "holds; end it with (value, True)."
        )
    if found:
        part, why = found
        start = "the value" if part == expression else shown(expression)
        return f"{start} {one_line(why)}; give finite real numbers."
    return None


Names = Iterable["str | Body | Constraint | Effect"]
# From names or symbols; a mapping whose keys were said would take no other mapping's variable.
Values = Mapping[Any, Any]
NamedValues = tuple[tuple[str, float], ...]

STEPS = (sympy.floor, sympy.ceiling, sympy.Mod)
CONDITIONS = (Relational, sympy.And, sympy.Or, sympy.Not)


def _why(misfit: KindError, value: object) -> str:
    """What a misfit says, and what to write in place of a value that is often given."""
    why = f" ({misfit})" if str(misfit) else ""
    if isinstance(value, str):
        return f"; {misfit}."
    if isinstance(value, Body):
        third = "z" if hasattr(type(value), "z") else "phi" if value.turns else ""
        names = f"{value.name}.x, {value.name}.y" + f" or {value.name}.{third}" * bool(third)
        return f"{why}; a body is none, but its coordinates are, {names}."
    if isfunction(value):
        return f"{why}; write what it computes, an expression, in place of the function."
    return f"{why}; give one value." if isinstance(value, tuple | list) else f"{why}."


def acting_while(value: sympy.Expr, condition: sympy.Basic) -> sympy.Expr:
    """A value while the condition holds, else zero."""
    return sympy.S.Zero if value == 0 else sympy.Piecewise((value, condition), (0, True))


class Reader:
    """Reads values, and notes a sentence about each that cannot be read."""

    def __init__(self) -> None:
        self.symbols: list[tuple[str, frozenset[sympy.Symbol]]] = []  # of the values, by place
        self.problems: list[str] = []  # the sentences, in order
        self.labels: dict[sympy.Basic, str] = {}  # condition → what its events are called

    def note(self, problem: str) -> None:
        """Add a problem, on one line."""
        self.problems.append(one_line(problem, 2000))

    def value(self, value: Any, unit: str, where: str, profile: bool = False) -> Any:
        """A number, quantity or expression in `unit`; 1 stands in for one that is noted."""
        if value is None:
            self.note(f"{where} is missing; give it{f' in {unit}' if unit else ''}.")
            return sympy.S.One
        try:
            read = plain_expression(in_unit(value, unit))
        except UnitError as misfit:
            self.note(f"{where}: {misfit}")
            return sympy.S.One
        except KindError as misfit:
            what = shown(value)
            self.note(f"{where}: {what} is neither a number nor an expression{_why(misfit, value)}")
            return sympy.S.One
        if problem := expression_problem(read, profile):
            self.note(f"{where}: {problem}")
            return sympy.S.One
        if read.free_symbols and not profile:
            self.symbols.append((where, frozenset(read.free_symbols)))
        return read

    def vector(self, value: Any, units: tuple[str, ...], where: str, word: str) -> tuple[Any, ...]:
        """As many values as `units`; anything else is noted, and read as (1, 0, ...)."""
        like = (1, *(0,) * (len(units) - 1))
        try:
            given = members(value, len(units))
        except KindError:
            self.note(f"{where}: {shown(value)} is not {len(units)} values; write {word}={like}.")
            given = [*like]
        return tuple(self.value(v, unit, where) for v, unit in zip(given, units, strict=True))

    def pairs(self, value: Any, where: str, word: str) -> list[list[Any]]:
        """The pairs of a list; anything else is noted, and read as an empty one."""
        try:
            return [members(pair, 2) for pair in members(value)]
        except KindError:
            self.note(f"{where}: {word}={shown(value)} is no list; write [(x, y), ...].")
            return []

    def gated(self, value: Any, unit: str, where: str, when: Any, label: str = "") -> Any:
        """A value while the condition `when` holds, else zero; None holds always.

        Events of the condition bear the `label`, if there is one.
        """
        force = self.value(value, unit, where)
        condition = self.condition(when, where, label)
        return force if condition is None else acting_while(force, condition)

    def condition(self, when: Any, where: str, label: str = "") -> Any:
        """A condition, whose events bear the label; None for one that always holds, or is none."""
        given: object = label
        is_text = isinstance(given, str) and bool(label.partition(" / ")[0].strip())
        if label and (when is None or not is_text):
            what = shown(given)
            self.note(f"{where}: label={what} names the events of when=; give both, in words.")
            label = ""
        if when is None:
            return None
        if not isinstance(when, CONDITIONS):
            constant = is_flag(when) or when is sympy.true or when is sympy.false
            reason = "never changes" if constant else "is no condition"
            self.note(
                f"{where}: when={shown(when)} {reason}; compare coordinates, velocities, "
                "parameters or t by <, <=, > or >=, joined by And, Or and Not, or leave it out."
            )
            return None
        if problem := self._condition_problem(when):
            self.note(f"{where}: when={shown(when)}: {problem}")
            return None
        self.symbols.append((where, frozenset(when.free_symbols)))
        if label:
            self.labels[when] = one_line(label)
        return when

    def _condition_problem(self, when: Any) -> str | None:
        """Why a condition can hold nowhere, or means nothing."""
        if isinstance(when, Relational):
            for jump in when.atoms(*STEPS):
                if kinds(jump, Coordinate, Velocity):
                    return f"{one_line(jump)} jumps where coordinates say; compare what is smooth."
            return next(filter(None, map(expression_problem, when.args)), None)
        if isinstance(when, CONDITIONS):
            return next(filter(None, map(self._condition_problem, when.args)), None)
        return f"{shown(when)} is no comparison; compare it with something."

    def number(self, value: Any, unit: str, where: str) -> float:
        """A plain number in `unit`."""
        try:
            return plain_float(in_unit(value, unit))
        except UnitError as misfit:
            self.note(f"{where}: {misfit}")
        except KindError as misfit:
            self.note(f"{where}: {shown(value)} is not a number{_why(misfit, value)}")
        return 1.0

    def finite(self, value: Any, unit: str, where: str) -> float:
        """A plain number that is neither infinite nor undefined."""
        number = self.number(value, unit, where)
        if isfinite(number):
            return number
        self.note(f"{where}: the value is {number}; give a finite number.")
        return 0.0

    def numbers(self, value: Any, unit: str, where: str, word: str, fewest: int) -> list[float]:
        """A list of plain finite numbers, whose entries are counted from 0."""
        try:
            given = members(value)
        except KindError as misfit:
            why = f" ({misfit})" if str(misfit) else ""
            self.note(f"{where}: {word} is {shown(value)}{why}; give at least {fewest} numbers.")
            return []
        return [self.finite(v, unit, f"{where}, {word}[{k}]") for k, v in enumerate(given)]

    def choice(self, value: Any, allowed: tuple[str, ...], where: str) -> Any:
        """One of a few words."""
        if isinstance(value, str) and value in allowed:
            return str(value)
        self.note(f"{where}: {shown(value)} is none of {', '.join(map(repr, allowed))}.")
        return allowed[0]

    def flag(self, value: Any, where: str, otherwise: bool = False) -> bool:
        """True or False, and nothing that Python takes for either."""
        if is_flag(value):
            return bool(value)
        self.note(f"{where}={shown(value)}: write True or False.")
        return otherwise

    def result_of(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], unit: str, where: str
    ) -> Any:
        """What a modeller's function returns for expressions, a value in `unit`; 0 if it fails."""
        try:
            result = function(*arguments)
        except Exception as error:
            self.note(
                f"{where}: the function fails with {failure(error)}; it "
                f"is called with {len(arguments)} expressions, and answers one."
            )
            return sympy.S.Zero
        if result is None:
            self.note(f"{where}: the function answers None; return the value.")
            return sympy.S.Zero
        return self.value(result, unit, where)

    def mapping(self, value: Any, word: str, like: str, where: str) -> Mapping[Any, Any]:
        """The mapping that the keyword `word` takes; None, and anything else, is read as empty."""
        if value is None or isinstance(value, Mapping):
            return value or {}
        self.note(f"{where}: {word}={shown(value)} is no mapping; write {like}.")
        return {}

    def names(self, value: Any, word: str, where: str, known: Mapping[str, Any]) -> list[str]:
        """Names of elements, given one or several, by name or as objects of the `known` ones."""
        given = [value]
        if not isinstance(value, str) and not isinstance(getattr(value, "name", None), str):
            try:
                if isinstance(value, Mapping) and any(known.get(k) is not value[k] for k in value):
                    raise KindError  # a table of the model's own lists its keys
                given = entries(value)
            except KindError:
                self.note(f"{where}: {word} {shown(value)} is no list; write ['a', 'b'].")
                return []
        chosen = [name_of(e) for e in given]
        for name, e in zip(chosen, given, strict=True):
            if not isinstance(e, str | sympy.Symbol) and known.get(name, e) is not e:
                self.note(f"{where}: {word} '{name}' is given as an object of another model.")
        return chosen

    def elements(
        self, names: Names, known: Mapping[str, Any], kind: str, where: str,
        others: Mapping[str, str] | None = None,
    ) -> tuple[str, ...]:  # fmt: skip
        """The known elements among `names`, in the order of their declaration.

        `others` says what names of other kinds stand for.
        """
        chosen = self.names(names, kind, where, known)
        for name in (n for n in chosen if n not in known):
            hint = (others or {}).get(name) or nearest(name, known)
            self.note(f"{where}: no {kind} '{name}'; {hint}")
        return tuple(name for name in known if name in chosen)

    def states(
        self, values: Any, unit_of: Callable[[str], str | None],
        known: Callable[[], Iterable[str]], word: str, where: str,
    ) -> NamedValues:  # fmt: skip
        """Values of coordinates, velocities and states, by ``"crank.phi"`` or their symbols.

        `unit_of` returns the SI unit of one, None where it is none, and `known` all that there are.
        """
        numbers = {}
        for key, value in self.mapping(values, word, "{'crank.phi': 1.0}", where).items():
            name = name_of(key)
            unit = unit_of(name)
            if unit is not None:
                numbers[name] = self.finite(value, unit, f"{where}, {name}")
            else:
                hint = nearest_quantity(name, known())
                self.note(f"{where}: '{name}' is no coordinate or velocity; {hint}")
        return tuple(numbers.items())

    def overrides(
        self, values: Any, parameters: Mapping[str, ParameterDeclaration], where: str
    ) -> NamedValues:
        """Values of parameters, in SI units."""
        numbers = {}
        given = self.mapping(values, "parameters", "{'mass': 2.0}", where)
        for name, value in ((name_of(key), value) for key, value in given.items()):
            if name in parameters:
                unit = parameters[name].unit
                numbers[name] = self.number(value, unit, f"{where}, parameter '{name}'")
            else:
                self.note(f"{where}: no parameter '{name}'; {nearest(name, parameters)}")
        return tuple(numbers.items())
