"""Values built from values, folding constants and structural zeros on the way; and substitution.

Where some values are replaced, every operation on them is built by the graph again, so that new
constants fold, new zeros annihilate, and values that become equal are one. A sine of a sum whose
second term does not move, such as the angle of a body that is fixed to another, becomes the sum of
products of what is known and the sine and cosine of the first.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import reduce

from codegen.lower.program import Lookup, Op, Value, dependencies
from codegen.lower.value_numbering import Numbering, Setting
from codegen.tables.piecewise_cubic import Table

ODD = frozenset({Op.SIN, Op.TAN, Op.ASIN, Op.ATAN, Op.SINH, Op.TANH})
EVEN = frozenset({Op.COS, Op.COSH})
SUMS = {Op.ADD: (1, 1), Op.SUB: (1, -1), Op.NEG: (-1,)}  # operations → signs of the arguments


class Graph(Numbering):
    """Arithmetic on numbered values.

    Signs are carried outside: -a is represented once, and of a - b and b - a one and its opposite,
    so that entries of Φ_q that differ in sign only share their work.
    """

    _cancelling = False

    def cancelling(self, on: bool = True) -> Setting:
        """Sums that are formed inside leave out a term that they would add and take back.

        Where the sum with that term is needed as well this may cost more than it saves.
        """
        return Setting(self, "_cancelling", on)

    # -- arithmetic --------------------------------------------------------------------------

    def neg(self, a: int) -> int:
        """-a."""
        number = self.floats[a]
        if number is not None:
            return self.constant(-number)
        value = self.values[a]
        return value.args[0] if value.op is Op.NEG else self._add(Op.NEG, (a,))

    def add(self, a: int, b: int) -> int:
        """a + b."""
        return self._sum(a, b, 1)

    def sub(self, a: int, b: int) -> int:
        """a - b."""
        return self._sum(a, b, -1)

    def _sum(self, a: int, b: int, sign: int) -> int:
        """a ± b, signs of its terms moved into the operation or outside."""
        x, y = self.floats[a], self.floats[b]
        if x is not None and y is not None:
            return self.constant(x + sign * y, "+" if sign > 0 else "-", x, y)
        if y == 0.0:
            return a
        if x == 0.0:
            return b if sign > 0 else self.neg(b)
        if a == b and sign < 0:
            return self.zero
        first, second = self.values[a].op, self.values[b].op
        if (second is Op.NEG if y is None else y < 0.0) and not (x is not None and x < 0.0):
            return self._sum(a, self.neg(b), -sign)
        if first is Op.NEG if x is None else x < 0.0:
            opposite = self._sum(b, self.neg(a), -sign)
            return opposite if sign > 0 else self.neg(opposite)
        if first is second is Op.SELECT and (one := self._merge_choices(a, b, sign)) is not None:
            return one
        may_cancel = self._cancelling and (first in SUMS or second in SUMS)
        if may_cancel and (shorter := self._cancelled(a, b, sign)) is not None:
            return shorter
        if sign > 0:
            return self._add(Op.ADD, (a, b))
        numbers = self._numbers
        if (Op.SUB, (b, a), None) in numbers and (Op.SUB, (a, b), None) not in numbers:
            return self.neg(self._add(Op.SUB, (b, a)))
        return self._add(Op.SUB, (a, b))

    def _merge_choices(self, a: int, b: int, sign: int) -> int | None:
        """The sum of two choices by one condition that are zero on the same side, as one choice."""
        (condition, *one), (other, *two) = self.values[a].args, self.values[b].args
        for k in (0, 1):
            if condition == other and one[k] == two[k] == self.zero:
                sides = [self.zero, self.zero]
                sides[1 - k] = self._sum(one[1 - k], two[1 - k], sign)
                return self.select(condition, *sides)
        return None

    def _cancelled(self, a: int, b: int, sign: int) -> int | None:
        """a ± b without a term that one adds and the other takes back; None where there is none."""
        ours, theirs = self._terms(a), self._terms(b)
        opposite = {~term for term in theirs} if sign > 0 else {*theirs}
        if opposite.isdisjoint(ours):
            return None
        term = next(term for term in ours if term in opposite)
        rest = self._without(a, term), self._without(b, ~term if sign > 0 else term)
        return self.add(*rest) if sign > 0 else self.sub(*rest)

    def _terms(self, a: int) -> list[int]:
        """The terms of a sum from the left, ~k for one that is subtracted."""
        values, stack, terms = self.values, [a], list[int]()
        while stack:
            number = stack.pop()
            value = values[number if number >= 0 else ~number]
            op = value.op
            if op is Op.MUL or op not in SUMS:
                terms.append(number)
            elif op is Op.NEG:
                stack.append(value.args[0] if number < 0 else ~value.args[0])
            else:
                one, other = value.args
                if number < 0:
                    one, other = ~one, ~other
                stack += (other if op is Op.ADD else ~other, one)
        return terms

    def _without(self, a: int, term: int) -> int:
        """A sum without one of its `_terms`."""
        path: list[tuple[int, bool]] = []  # sums from `a` down to the term, and which side it is on
        while (value := self.values[a]).op in SUMS:
            first = value.op is Op.NEG or term in self._terms(value.args[0])
            path.append((a, first))
            a = value.args[0 if first else 1]
            term = term if value.op is Op.ADD or (first and value.op is Op.SUB) else ~term
        rest = self.zero
        for number, first in reversed(path):
            op, args = self.values[number].op, self.values[number].args
            if op is Op.NEG:
                rest = self.neg(rest)
            else:
                pair = (rest, args[1]) if first else (args[0], rest)
                rest = self.add(*pair) if op is Op.ADD else self.sub(*pair)
        return rest

    def mul(self, a: int, b: int) -> int:
        """a b; a structural zero annihilates, a sign moves outside."""
        x, y = self.floats[a], self.floats[b]
        if y is not None:
            if x is not None:
                return self.constant(x * y, "*", x, y)
            a, b, x, y = b, a, y, None
        if x == 0.0:
            return self.zero
        if x == 1.0:
            return b
        first, second = self.values[a].op, self.values[b].op
        if first is Op.NEG if x is None else x < 0.0:
            return self.neg(self.mul(self.neg(a), b))
        if second is Op.NEG:
            return self.neg(self.mul(self.neg(b), a))
        if x is not None and second is Op.MUL:
            for inner, rest in (pair := self.values[b].args, pair[::-1]):
                if (z := self.floats[inner]) is not None:
                    return self.mul(self.constant(x * z, "*", x, z), rest)
        if first is Op.SELECT or second is Op.SELECT:
            for one, other in ((a, b), (b, a)):
                if (inside := self._move_into_choice(one, other)) is not None:
                    return inside
        return self._add(Op.MUL, (a, b))

    def _move_into_choice(self, choice: int, factor: int) -> int | None:
        """A product with a choice that is zero on one side, computed on the other only."""
        if self.values[choice].op is not Op.SELECT:
            return None
        condition, yes, no = self.values[choice].args
        if self.zero in (yes, no) and (self.settled[factor] or self.one in (yes, no)):
            return self.select(condition, self.mul(yes, factor), self.mul(no, factor))
        return None

    def div(self, a: int, b: int) -> int:
        """a / b; a division by a value known before the run becomes a product."""
        x, y = self.number(a), self.number(b)
        if x is not None and y is not None and y != 0.0:
            return self.constant(x / y, "/", x, y)
        if x == 0.0:
            return self.zero
        if y is not None and y != 0.0:
            return self.mul(self.constant(1.0 / y, "/", 1.0, y), a)
        if self._is_negative(a):
            return self.neg(self.div(self.neg(a), b))
        if self._is_negative(b):
            return self.neg(self.div(a, self.neg(b)))
        if self.settled[b] and not self.settled[a]:
            return self.mul(self.div(self.one, b), a)
        return self._add(Op.DIV, (a, b))

    def power(self, base: int, exponent: float) -> int:
        """base ** exponent; small whole and half exponents by products and a square root."""
        if exponent < 0:
            return self.div(self.one, self.power(base, -exponent))
        if exponent == 0.5:
            return self.function(Op.SQRT, base)
        whole = int(exponent)
        if exponent == whole + 0.5 and whole < 16:
            return self.mul(self.power(base, whole), self.function(Op.SQRT, base))
        if exponent != whole or whole > 64:
            return self.function(Op.POW, base, self.constant(exponent))
        result, square = self.one, base
        while whole:
            if whole & 1:
                result = self.mul(result, square)
            whole >>= 1
            if whole:
                square = self.mul(square, square)
        return result

    def function(self, op: Op, *args: int) -> int:
        """An elementary function; numbers are folded, sin(-x) = -sin(x), cos(-x) = cos(x)."""
        numbers = [n for a in args if (n := self.number(a)) is not None]
        if len(numbers) == len(args):
            with suppress(ValueError, OverflowError):  # left to the run: log(0) is -inf there
                return self.constant(getattr(math, op.value)(*numbers), op.value, *numbers)
        if op in ODD | EVEN and self.values[args[0]].op is Op.NEG:
            inner = self._add(op, self.values[args[0]].args)
            return self.neg(inner) if op in ODD else inner
        return self._add(op, args)

    def lookup(self, table: Table, order: int, at: int) -> int:
        """A derivative of a table; numbers are folded."""
        number = self.number(at)
        if number is not None:
            return self.constant(float(table(number, order)))
        return self._add(Op.TABLE, (at,), Lookup(table, order))

    def total(self, terms: list[int]) -> int:
        """The sum of `terms`, from the left."""
        return reduce(self.add, terms, self.zero)

    def dot(self, xs: Iterable[int], ys: Iterable[int]) -> int:
        """Σ x y."""
        return self.total([self.mul(x, y) for x, y in zip(xs, ys, strict=True)])

    def less(self, start: int, row: Mapping[int, int], x: Mapping[int, int]) -> int:
        """start - Σ factor x, of a row of factors."""
        for j, factor in row.items():
            start = self.sub(start, self.mul(factor, x[j]))
        return start

    def indicates(self, a: int) -> bool:
        """Whether `a` is ±1 where a condition holds and 0 where not, or the other way round."""
        value = self.values[a]
        if value.op is Op.NEG:
            return self.indicates(value.args[0])
        return value.op is Op.SELECT and set(value.args[1:]) == {self.zero, self.one}

    def unsigned(self, a: int) -> int:
        """`a` without the sign outside."""
        return self.values[a].args[0] if self.values[a].op is Op.NEG else a

    def has_product(self, a: int, b: int) -> bool:
        """Whether a b is there already."""
        return (Op.MUL, tuple(sorted((a, b))), None) in self._numbers

    def _is_negative(self, a: int) -> bool:
        """Whether `a` is a negative number or has a sign outside."""
        number = self.number(a)
        return self.values[a].op is Op.NEG if number is None else number < 0.0

    # -- choice ------------------------------------------------------------------------------

    def negation(self, a: int) -> int:
        """Not a."""
        value = self.values[a]
        return value.args[0] if value.op is Op.NOT else self._add(Op.NOT, (a,))

    def is_less(self, a: int, b: int) -> int:
        """Whether a < b."""
        return self._add(Op.LESS, (a, b))

    def logical(self, op: Op, a: int, b: int) -> int:
        """a and b, a or b."""
        return a if a == b else self._add(op, (a, b))

    def select(self, condition: int, yes: int, no: int) -> int:
        """`yes` where `condition` holds, else `no`; only the one needed is computed."""
        if yes == no:
            return yes
        if self.values[condition].op is Op.NOT:
            return self.select(self.values[condition].args[0], no, yes)
        if self.zero in (yes, no) and self._is_negative(no if yes == self.zero else yes):
            return self.neg(self.select(condition, self.neg(yes), self.neg(no)))
        return self._add(Op.SELECT, (condition, yes, no))


def substitute(graph: Graph, outputs: Sequence[int], replaced: Mapping[int, int]) -> list[int]:
    """The outputs with each value in `replaced` replaced, as values of the same graph."""
    known = dict(replaced)
    for number in sorted(dependencies(graph.values, outputs, replaced) - replaced.keys()):
        value = graph.values[number]
        args = tuple(known[a] for a in value.args)
        known[number] = number
        if args != value.args:
            with graph.serving(value.serves):
                known[number] = with_arguments(graph, value, args)
    return [known[number] for number in outputs]


def with_arguments(graph: Graph, value: Value, args: tuple[int, ...]) -> int:
    """The operation of a value on other arguments."""
    if value.op in ARITHMETIC:
        return ARITHMETIC[value.op](graph, *args)
    if value.op in (Op.SIN, Op.COS):
        return expand_sine(graph, value.op, *args)
    if value.op is Op.POW and (exponent := graph.number(args[1])) is not None:
        return graph.power(args[0], exponent)
    if isinstance(value.literal, Lookup):
        return graph.lookup(value.literal.table, value.literal.order, *args)
    return graph.function(value.op, *args)


def expand_sine(graph: Graph, op: Op, angle: int) -> int:
    """sin or cos of an angle; of a sum with a constant angle by the addition theorems."""
    value = graph.values[angle]
    if value.op is Op.NEG:
        same = expand_sine(graph, op, value.args[0])
        return graph.neg(same) if op is Op.SIN else same
    if value.op not in (Op.ADD, Op.SUB) or graph.settled[angle]:
        return graph.function(op, angle)
    moving, fixed = value.args
    moving_sign, fixed_sign = 1, -1 if value.op is Op.SUB else 1
    if graph.settled[moving]:
        moving, fixed, moving_sign, fixed_sign = fixed, moving, fixed_sign, 1
    if not graph.settled[fixed]:
        return graph.function(op, angle)
    s, c = expand_sine(graph, Op.SIN, moving), expand_sine(graph, Op.COS, moving)
    fixed_s, fixed_c = graph.function(Op.SIN, fixed), graph.function(Op.COS, fixed)
    s = s if moving_sign > 0 else graph.neg(s)
    fixed_s = fixed_s if fixed_sign > 0 else graph.neg(fixed_s)
    if op is Op.SIN:
        return graph.add(graph.mul(fixed_c, s), graph.mul(fixed_s, c))
    return graph.sub(graph.mul(fixed_c, c), graph.mul(fixed_s, s))


ARITHMETIC: dict[Op, Callable[..., int]] = {
    Op.ADD: Graph.add,
    Op.SUB: Graph.sub,
    Op.MUL: Graph.mul,
    Op.DIV: Graph.div,
    Op.NEG: Graph.neg,
    Op.NOT: Graph.negation,
    Op.AND: lambda graph, a, b: graph.logical(Op.AND, a, b),
    Op.OR: lambda graph, a, b: graph.logical(Op.OR, a, b),
    Op.LESS: Graph.is_less,
    Op.SELECT: Graph.select,
}
