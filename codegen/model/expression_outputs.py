"""Outputs that a modeller writes as expressions, and symbols for the series of results in them."""

from collections.abc import Iterator, Mapping
from itertools import chain
from math import prod
from typing import Any

import sympy

from codegen.declare.scene import ExpressionOutput
from codegen.declare.symbols import Coordinate, ResultSeries, Velocity, dotted, kinds, t
from codegen.declare.value_reader import Reader
from codegen.model.base import Declarations
from codegen.readers.quantities import known_unit, measured, si_factor, si_unit, whole_unit
from codegen.readers.values import name_problem, nearest, shown

TAKEN = ("time", "kinetic", "potential", "total")  # series that belong to no element
_UNITS = {
    **dict.fromkeys(("fx", "fy", "fz", "axial", "force", "normal"), "N"),
    **dict.fromkeys(("global_fx", "global_fy"), "N"),
    **dict.fromkeys(("torque", "tx", "ty", "tz"), "N m"),
    **dict.fromkeys(("ax", "ay", "az"), "m/s^2"),
}
"""Components of series whose units are known."""
_SUMS = (sympy.Add, sympy.Abs, sympy.Max, sympy.Min)
_ANGLES = (sympy.asin, sympy.acos, sympy.atan, sympy.atan2)
_PURE = (sympy.sin, sympy.cos, sympy.tan, sympy.tanh, sympy.exp, sympy.log, sympy.sign)


class ExpressionOutputs(Declarations):
    """Outputs that are expressions."""

    def series(self, name: str) -> ResultSeries:
        """A series of results, by its name there, for the expressions among a scene's outputs.

        Such as ``"A.fx"``, ``"strut.force"``, ``"a(crank.phi)"``, ``"tip.ax"``, ``"ground.fx"``.
        """
        symbol = ResultSeries(str(name), real=True)
        known = {"ground": None, **self.bodies, **self.joints, **self.drivers, **self.effects}
        is_own = self.unit_of(symbol.name)
        if is_own or "." not in symbol.name or symbol.owner not in known:
            hint = f"write {name} alone." if is_own else nearest(symbol.owner, known)
            self._note(f"series({shown(name)}): give the name of a series, such as 'A.fx'; {hint}")
        return symbol

    def _read_expressions(self, read: Reader, where: str, given: Any) -> Iterator[ExpressionOutput]:
        """The outputs that are expressions, each with a name that nothing else has."""
        tables = given if isinstance(given, list | tuple) else [given]
        named = self._kinds | dict.fromkeys(TAKEN, "series")
        for name, value in chain(*(one.items() for one in tables if isinstance(one, Mapping))):
            kind = named.get(name)
            taken = f"output '{name}': {kind} '{name}' has the name already; give another."
            if problem := name_problem("output", name) or taken * bool(kind):
                read.note(f"{where}: {problem}")
                continue
            named[name] = "output"
            place, pair = f"{where}, output '{name}'", isinstance(value, tuple) and len(value) == 2
            expression, unit = value if pair else (value, None)
            expression = read.value(expression, "", place)
            series = {*kinds(expression, ResultSeries)}
            read.symbols = [(w, s - series if w == place else s) for w, s in read.symbols]
            if unit is None:
                one = self._unit(expression)
                unit = "" if one is None else whole_unit(one)
            elif not known_unit(unit) or si_factor(unit) != 1.0:
                why = f"expressions are in SI, and r.series({name!r}, {shown(unit)}) converts."
                read.note(f"{place}: the unit {shown(unit)} is none of SI; {why}")
            yield ExpressionOutput(name, expression, unit)

    def _unit(self, node: sympy.Expr) -> Any:
        """One in the SI unit of an expression, in which r φ is in m; None: it is not known."""
        if node.is_Symbol:
            text = self._unit_of_symbol(node)
            return None if text is None or not known_unit(text) else measured(1.0, si_unit(text))
        terms = [part for part in node.args if not part.is_number]
        if node.is_Add:  # a number may be a length or the like
            terms = [term for term in terms if abs(term.as_coeff_Mul()[0]) == 1] or terms
        parts = [self._unit(term) for term in terms]
        if node.func in (*_ANGLES, *_PURE):
            return measured(1.0, "rad" if node.func in _ANGLES else "")
        is_sum, is_power = isinstance(node, _SUMS), node.is_Pow and node.exp.is_number
        is_alike = len({str(part and part.to_base_units()) for part in parts}) == 1
        is_known = is_alike if is_sum else node.is_Mul or node.is_number or is_power
        if None in parts or not is_known:
            return None
        whole = parts[0] if is_sum else prod(parts, start=measured(1.0, ""))
        whole = whole ** float(node.exp) if is_power else whole
        powers = dict(whole.unit_items())
        is_product = "radian" in powers and not {*powers} <= {"radian", "second"}
        return whole / measured(1.0, "rad") ** powers["radian"] if is_product else whole

    def _unit_of_symbol(self, symbol: sympy.Symbol) -> str | None:
        """The SI unit of a symbol in an expression; None where it is not known."""
        if isinstance(symbol, ResultSeries):
            unit = self.unit_of(symbol.name[2:-1])  # of a coordinate
            return f"{unit}/s^2" if unit else _UNITS.get(symbol.name.rpartition(".")[2])
        if isinstance(symbol, Coordinate | Velocity):
            return self.unit_of(dotted(symbol))
        return "s" if symbol == t else getattr(self.parameters.get(symbol.name), "unit", None)
