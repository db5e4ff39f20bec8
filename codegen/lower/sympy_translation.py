"""SymPy expression → values of a `Graph`, one visit a node.

Factors and terms are gathered from what changes least to what changes most (numbers, parameters,
positions, velocities), so that as much as possible is known before a run, and products such as
s'_x cos φ that occur in Φ, Φ_q and γ come out as one value.
"""

from collections import ChainMap
from collections.abc import Mapping, Sequence
from functools import partial, reduce
from typing import Any

import sympy
from sympy.core.relational import Relational

from codegen.declare.rotation_entries import RotationEntry, RotationVectorEntry, SpinEntry
from codegen.declare.symbols import Coordinate, Velocity, kinds
from codegen.derive.piecewise_conditions import (
    INVERSES,
    KINKED,
    STEPS,
    Boundary,
    as_pieces,
    boundary,
    switching_function,
    without_marks,
)
from codegen.derive.switching_functions import Switch, find_switch
from codegen.errors import LinkwrightError, ModelError
from codegen.lower.differentiation.turning import rotation_entry, spin_entry
from codegen.lower.graph import Graph
from codegen.lower.program import ELEMENTARY, Input, Op, dependencies
from codegen.readers.calls import unreadable
from codegen.readers.expressions import constant_value, powers_with_number_outside
from codegen.tables.piecewise_function import ClosedPieces
from codegen.tables.table_function import Interpolant

FUNCTIONS = {getattr(sympy, name): Op(name) for name in ELEMENTARY if name not in ("sqrt", "pow")}

# how often an argument changes
RANKS = {"p": 1, "t": 2, "stiction": 2, "q": 3, "v": 4, "a": 5, "lam": 6, "reaction": 6}


class Translator:
    """Translates expressions into one graph.

    `environment` maps symbols, and other expressions that are known as a whole, to values,
    `switches` are those of the scene, in the order of their modes; None: conditions are compared.
    """

    def __init__(
        self, graph: Graph, environment: Mapping[sympy.Expr, int],
        switches: Sequence[Switch] | None, compares: bool = False,
    ) -> None:  # fmt: skip
        self.graph, self.switches = graph, switches
        self.environment = ChainMap(dict(environment))
        self._compares = compares  # whether a condition that no switch has is compared
        self._known: dict[sympy.Basic, int] = {}
        self._ranks: dict[int, int] = {}

    def scoped(self, bindings: Mapping[sympy.Expr, sympy.Expr | int]) -> "Translator":
        """A translator that knows an element's placeholders in addition to the model's symbols."""
        inner = Translator(self.graph, {}, self.switches, self._compares)
        own = self.environment  # of two dictionaries at the most
        inner.environment = (own if len(own.maps) < 2 else ChainMap(dict(own))).new_child()
        for place, meaning in bindings.items():
            inner.environment[place] = meaning if isinstance(meaning, int) else self(meaning)
        inner._known = {place: inner.environment[place] for place in bindings}
        return inner

    @property
    def comparing(self) -> "Translator":
        """A translator of the same symbols for what a run only reads: it needs no switches."""
        return Translator(self.graph, self.environment, self.switches, compares=True)

    def __call__(self, expression: Any) -> int:
        """The value of `expression`; a failure of SymPy's names what the graph serves."""
        try:
            node = expression if isinstance(expression, sympy.Basic) else sympy.sympify(expression)
            known = self._known.get(node)
            if known is None:
                known = self._known[node] = self._translate(node)
            return known
        except LinkwrightError:
            raise
        except Exception as error:
            if not self.graph.serves:
                raise
            raise ModelError(f"'{self.graph.serves}': {unreadable(error)}") from error

    def _translate(self, node: Any) -> int:
        graph = self.graph
        if node.is_Symbol:
            number: int = self.environment[node]
            return number
        if node.is_number:
            return graph.constant(constant_value(node))
        if node.is_Add:
            return self._sum([self(a) for a in node.args])
        if node.is_Mul:
            return self._product(node)
        if node.is_Pow:
            base, exponent = node.as_base_exp()
            if exponent.is_number:
                return graph.power(self(base), float(exponent))
            return graph.function(Op.POW, self(base), self(exponent))
        if isinstance(node, sympy.Piecewise):
            return self._piecewise(node)
        if isinstance(node, RotationEntry):
            i, k, *p = node.args
            return rotation_entry(graph, int(i), int(k), [self(e) for e in p])
        if isinstance(node, SpinEntry):
            k, *at = node.args
            values = [self(e) for e in at]
            return spin_entry(graph, int(k), values[:4], values[4:])
        if isinstance(node, RotationVectorEntry):
            return self(node.polynomial())
        if isinstance(node, Interpolant):
            return graph.lookup(node.table, node.order, self(node.at))
        if isinstance(node, ClosedPieces):  # the steps of a run end where they meet
            return Translator(graph, self.environment, None)(as_pieces(node.expression))
        if node.func in (*KINKED, *STEPS) and node.func not in FUNCTIONS:
            return self(as_pieces(node))
        if node.func in INVERSES and (pieces := as_pieces(node)) != node:
            return self(pieces)
        if node.func in FUNCTIONS:
            return graph.function(FUNCTIONS[node.func], *(self(a) for a in node.args))
        if isinstance(node, sympy.logic.boolalg.BooleanFunction | Relational):
            return self._condition(node)
        raise ModelError(
            f"'{graph.serves}': the function {node.func} in {node} cannot be compiled; "
            f"known are {', '.join(sorted(str(f) for f in FUNCTIONS))}, powers and Piecewise."
        )

    def _sum(self, terms: list[int]) -> int:
        """Terms that turn with one angle first, so that the components of A s are values."""
        graph = self.graph
        groups: dict[tuple[bool, int], list[int]] = {}
        for number in self._in_order(terms):
            angle = self._angle(number)
            key = (False, graph.movers(number)) if angle is None else (True, angle)
            groups.setdefault(key, []).append(number)
        return graph.total([graph.total(group) for group in groups.values()])

    def _angle(self, number: int) -> int | None:
        """The angle θ of a term a cos θ or a sin θ; of two the first."""
        values = self.graph.values
        value = values[number]
        if value.op is Op.NEG:
            return self._angle(value.args[0])
        factors = value.args if value.op is Op.MUL else (number,)
        turning = [values[k].args[0] for k in factors if values[k].op in (Op.SIN, Op.COS)]
        return min(turning, default=None)

    def _product(self, node: sympy.Mul) -> int:
        numerator, denominator = [], []
        if powers := powers_with_number_outside(node):
            return self._with_number_inside(node, powers)
        for factor in node.args:
            base, exponent = factor.as_base_exp()
            if exponent.is_number and exponent < 0:
                denominator.append(self(base**-exponent))
            else:
                numerator.append(self(factor))
        top, bottom = (
            reduce(self.graph.mul, self._in_order(factors), self.graph.one)
            for factors in (numerator, denominator)
        )
        return self.graph.div(top, bottom) if denominator else top

    def _with_number_inside(self, node: sympy.Mul, powers: Sequence[sympy.Expr]) -> int:
        """c b^x as ±exp(x log b + log|c|), for no float holds c."""
        number, *factors = node.args
        pairs = [power.as_base_exp() for power in powers]
        exponents = [self(exponent * sympy.log(base)) for base, exponent in pairs]
        inside = self._sum([*exponents, self(sympy.log(abs(number)))])
        rest = self(sympy.Mul(sympy.sign(number), *(f for f in factors if f not in powers)))
        return self.graph.mul(self.graph.function(Op.EXP, inside), rest)

    def _piecewise(self, node: sympy.Piecewise) -> int:
        *pieces, last = node.args
        if last.cond != sympy.true:
            raise ModelError(
                f"'{self.graph.serves}': {node} says nothing where none of its conditions holds; "
                "end it with (value, True)."
            )
        result = self(last.expr)
        for piece in reversed(pieces):
            condition, value, other = self._condition(piece.cond), self(piece.expr), result
            result = self.graph.select(condition, value, other)
            if (rest := self._middle_at_rest(piece.cond, value, other)) is not None:
                result = self.graph.select(*rest, result)
        return result

    def _middle_at_rest(self, condition: Any, value: int, other: int) -> tuple[int, int] | None:
        """Of a balanced condition among others: whether its switch is at rest, and its mean."""
        if not (isinstance(condition, Relational) and boundary(condition) is Boundary.BALANCED):
            return None
        if self.switches is None:
            return None
        found = find_switch(switching_function(condition), Boundary.BALANCED, self.switches)
        if found is None or self.switches[found[0]].boundary is not Boundary.MIXED:
            return None
        graph = self.graph
        return graph.is_sliding(found[0]), graph.mul(graph.add(value, other), graph.constant(0.5))

    def _condition(self, node: Any) -> int:
        graph = self.graph
        if isinstance(node, sympy.Not):
            return graph.negation(self._condition(node.args[0]))
        if isinstance(node, sympy.And | sympy.Or):
            op = Op.AND if isinstance(node, sympy.And) else Op.OR
            return reduce(partial(graph.logical, op), sorted(self._condition(a) for a in node.args))
        if self.switches is None:
            return self._comparison(node)
        found = find_switch(switching_function(node), boundary(node), self.switches)
        if found is not None:
            switch, opposite = found
            holds, own = graph.mode(switch), boundary(node)
            closed = (own.of_opposite() if opposite else own) is Boundary.CLOSED
            if self.switches[switch].boundary is Boundary.MIXED and not closed:
                rests = graph.is_sliding(switch)
                holds = graph.logical(Op.AND, holds, graph.negation(rests))
            return graph.negation(holds) if opposite else holds
        if kinds(node, Coordinate, Velocity) and not self._compares:
            raise ModelError(
                f"'{graph.serves}': the condition {node} stands where nothing may switch (a "
                "constraint or a driver); write the motion as one smooth expression."
            )
        return self._comparison(node)  # the steps of a run end where it changes

    def _comparison(self, node: Any) -> int:
        graph, node = self.graph, without_marks(node)
        low, high = self(node.lts), self(node.gts)
        strict = isinstance(node, sympy.StrictGreaterThan | sympy.StrictLessThan)
        return graph.is_less(low, high) if strict else graph.negation(graph.is_less(high, low))

    def _in_order(self, numbers: list[int]) -> list[int]:
        """By how often the values change, by what moves them, by number: by the declaration."""
        return sorted(numbers, key=lambda n: (self._rank(n), self.graph.movers(n), n))

    def _rank(self, number: int) -> int:
        values, ranks = self.graph.values, self._ranks
        if number not in ranks:
            # Those of a sum or a product were asked for before it.
            near = all(a in ranks for a in values[number].args)
            for k in [number] if near else sorted(dependencies(values, [number], ranks)):
                if k in ranks:
                    continue
                literal = values[k].literal
                if isinstance(literal, Input):
                    ranks[k] = RANKS[literal.array]
                else:
                    inner = [ranks[a] for a in values[k].args]
                    ranks[k] = 0 if values[k].op is Op.CONST else max(inner, default=2)
        return ranks[number]
