"""Value numbering: leaves and operations, each once, and the inputs that each depends on."""

import math
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import reduce
from operator import or_
from typing import Self

from codegen.errors import ModelError
from codegen.lower.program import COMMUTATIVE, Folded, Input, Literal, Op, Value


class Numbering:
    """A growing list of values in which equal values are one value."""

    def __init__(self) -> None:
        self.values: list[Value] = []  # in order of their numbers
        self.settled: list[bool] = []  # whether numbers and parameters alone determine a value
        # for each value, the inputs but parameters that it depends on, as bits of `place_of`
        self.movers: list[int] = []
        self._places: dict[int, int] = {}
        self._numbers: dict[tuple[Op, tuple[int, ...], object], int] = {}
        self.serves = ""
        self.zero = self.constant(0.0)
        self.one = self.constant(1.0)
        self.minus_one = self.constant(-1.0)

    @classmethod
    def of(cls, values: Iterable[Value]) -> Self:
        """A graph that goes on from the values of a program, under the numbers that they have."""
        graph = cls()
        for value in values:
            with graph.serving(value.serves):
                graph._add(value.op, value.args, value.literal, value.origin)
        return graph

    @contextmanager
    def _during(self, **settings: object) -> Iterator[None]:
        """Attributes with other values inside."""
        before = {name: getattr(self, name) for name in settings}
        vars(self).update(settings)
        try:
            yield
        finally:
            vars(self).update(before)

    def serving(self, name: str) -> AbstractContextManager[None]:
        """Values first needed inside are credited to `name`."""
        return self._during(serves=name)

    def _add(
        self, op: Op, args: tuple[int, ...], literal: Literal = None, origin: Folded | None = None
    ) -> int:
        if op in COMMUTATIVE:
            args = tuple(sorted(args))
        key = (op, args, literal)
        if key not in self._numbers:
            self._numbers[key] = len(self.values)
            self.values.append(Value(op, args, literal, self.serves, origin))
            self.settled.append(
                literal.array == "p"
                if isinstance(literal, Input)
                else op is not Op.MODE and all(self.settled[a] for a in args)
            )
            moves = reduce(or_, (self.movers[a] for a in args), 0)
            if isinstance(literal, Input) and not self.settled[-1]:
                moves = 1 << self.place_of(self._numbers[key])
            self.movers.append(moves)
        return self._numbers[key]

    def place_of(self, number: int) -> int:
        """The bit of an input in `movers`."""
        return self._places.setdefault(number, len(self._places))

    # -- leaves ------------------------------------------------------------------------------

    def constant(self, number: float, sign: str = "", *numbers: float) -> int:
        """A number, or the result of the operation `sign` on `numbers`.

        Raises ModelError if it is not finite: the model multiplies or adds beyond all bounds.
        """
        if not math.isfinite(number):
            where = f" of '{self.serves}'" if self.serves else ""
            constants = (v for v in self.values if v.op is Op.CONST)
            one = max(constants, key=lambda v: abs(v.literal))  # type: ignore[arg-type]
            raise ModelError(
                f"an expression{where} comes to {number} when its numbers are multiplied out; "
                f"give numbers that a float can hold (the largest, {one.literal:g}, is of "
                f"'{one.serves}')."
            )
        known = abs(number) in (abs(other) for other in numbers)
        origin = Folded(sign, numbers) if sign and not known else None
        return self._add(Op.CONST, (), float(number) + 0.0, origin)  # no negative zero

    def input(self, array: str, index: int, name: str) -> int:
        """A slot of an argument."""
        return self._add(Op.INPUT, (), Input(array, index, name))

    def mode(self, index: int) -> int:
        """Whether the condition of switching function `index` holds."""
        return self._add(Op.MODE, (), index)

    def is_sliding(self, index: int) -> int:
        """Whether the motion stays on the surface g = 0 of switching function `index`, mode 2."""
        return self._add(Op.SLIDING, (self.mode(index),))

    def number(self, a: int) -> float | None:
        """The number that `a` is, or None if it is only known at run time."""
        value = self.values[a]
        return value.literal if value.op is Op.CONST else None  # type: ignore[return-value]
