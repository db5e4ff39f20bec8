"""Outputs that a modeller writes as expressions, and symbols for the series of results in them."""

import re
from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any

import sympy

from codegen.declare.scene import ExpressionOutput
from codegen.declare.symbols import Coordinate, ResultSeries, Velocity, dotted, kinds, t
from codegen.declare.value_reader import Reader
from codegen.model.base import Declarations
from codegen.readers.quantities import known_unit, si_factor
from codegen.readers.values import name_problem, nearest, shown

TAKEN = ("time", "kinetic", "potential", "total")  # series that belong to no element
_UNITS = {
    **dict.fromkeys(("fx", "fy", "global_fx", "global_fy", "force", "normal"), "N"),
    "torque": "N m",
    "ax": "m/s^2",
    "ay": "m/s^2",
}
"""Components of series whose units are known."""
_FACTOR = re.compile(r"([A-Za-z°%]+)(?:\^(-?\d+))?")
_SUMS = (sympy.Add, sympy.Abs, sympy.Max, sympy.Min)
_ANGLES = (sympy.asin, sympy.acos, sympy.atan, sympy.atan2)
_PURE = (sympy.sin, sympy.cos, sympy.tan, sympy.tanh, sympy.exp, sympy.log, sympy.sign)
_RAD, _SECOND = sympy.symbols("rad s", positive=True)


class ExpressionOutputs(Declarations):
    """Outputs that are expressions."""

    def series(self, name: str) -> ResultSeries:
        """A series of results, by its name there, for the expressions among a scene's outputs.

        Such as ``"A.fx"``, ``"strut.force"``, ``"a(crank.phi)"``, ``"tip.ax"``, ``"ground.fx"``.
        """
        symbol = ResultSeries(str(name), real=True)
        known = {"ground": None, **self.bodies, **self.joints, **self.drivers, **self.effects}
        if "." not in symbol.name or symbol.owner not in known:
            hint = nearest(symbol.owner, known)
            self._note(f"series({shown(name)}): give the name of a series, such as 'A.fx'; {hint}")
        return symbol

    def _read_expressions(self, read: Reader, where: str, given: Any) -> Iterator[ExpressionOutput]:
        """The outputs that are expressions, each with a name that nothing else has."""
        tables = given if isinstance(given, list | tuple) else [given]
        for name, value in chain(*(one.items() for one in tables if isinstance(one, Mapping))):
            kind = self._kinds.get(name, "series" * (name in TAKEN))
            taken = f"output '{name}': the name is already that of a {kind}; give another."
            if problem := name_problem("output", name) or taken * bool(kind):
                read.note(f"{where}: {problem}")
                continue
            place, pair = f"{where}, output '{name}'", isinstance(value, tuple) and len(value) == 2
            expression, unit = value if pair else (value, None)
            expression = read.value(expression, "", place)
            series = {*kinds(expression, ResultSeries)}
            read.symbols = [(w, s - series if w == place else s) for w, s in read.symbols]
            if unit is None:
                unit = str(self._unit(expression) or "").replace("**", "^").replace("*", " ")
            elif not known_unit(unit) or si_factor(unit) != 1.0:
                why = f"expressions are in SI, and r.series({name!r}, {shown(unit)}) converts."
                read.note(f"{place}: the unit {shown(unit)} is none of SI; {why}")
            yield ExpressionOutput(name, expression, unit)

    def _unit(self, node: sympy.Expr) -> sympy.Expr | None:
        """The SI unit of an expression, in which r φ is in m, by powers; None: it is not known."""
        if node.is_Symbol:
            if (text := self._unit_of_symbol(node)) is None:
                return None
            found, sign = sympy.S.One, 1
            for side in text.split("/"):
                for unit, power in _FACTOR.findall(side):
                    found *= sympy.Symbol(unit, positive=True) ** (sign * int(power or 1))
                sign = -1  # all behind a stroke is below it
            return found
        terms = [part for part in node.args if not part.is_number]
        if node.is_Add:  # a number may be a length or the like
            terms = [term for term in terms if abs(term.as_coeff_Mul()[0]) == 1] or terms
        parts = [self._unit(term) for term in terms]
        whole: Any = sympy.Mul(*(part or 0 for part in parts))
        if isinstance(node, _SUMS):
            whole = parts[0] if len({*parts}) == 1 else None
        elif node.is_Pow and node.exp.is_number:
            whole = whole**node.exp
        elif not (node.is_Mul or node.is_number):
            whole = _RAD if node.func in _ANGLES else sympy.S.One if node.func in _PURE else None
        is_product = whole and not whole.free_symbols <= {_RAD, _SECOND}
        return whole.subs(_RAD, 1) if is_product else whole or None

    def _unit_of_symbol(self, symbol: sympy.Symbol) -> str | None:
        """The SI unit of a symbol in an expression; None where it is not known."""
        if isinstance(symbol, ResultSeries):
            unit = self.unit_of(symbol.name[2:-1])  # of a coordinate
            return f"{unit}/s^2" if unit else _UNITS.get(symbol.name.rpartition(".")[2])
        if isinstance(symbol, Coordinate | Velocity):
            return self.unit_of(dotted(symbol))
        return "s" if symbol == t else getattr(self.parameters.get(symbol.name), "unit", None)
