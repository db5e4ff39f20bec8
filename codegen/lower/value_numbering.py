"""Value numbering: leaves and operations, each once, and the inputs that each depends on."""

import math
from collections.abc import Iterable, Sequence
from functools import reduce
from operator import or_
from typing import Self

from codegen.errors import ModelError
from codegen.lower.program import COMMUTATIVE, Folded, Input, Literal, Op, Value, dependencies

_value = tuple.__new__  # measured: a named tuple's own takes four times as long


class Numbering:
    """A growing list of values in which equal values are one value."""

    def __init__(self) -> None:
        self.values: list[Value] = []  # in order of their numbers
        self.settled: list[bool] = []  # whether numbers and parameters alone determine a value
        self.floats: list[float | None] = []  # the number that a value is, None: known in a run
        # for values that were asked for, the inputs but parameters that each depends on, as bits of
        # `place_of`; equal sets are one object
        self._movers: dict[int, int] = {}
        self._sets: dict[int, int] = {}
        self._places: dict[int, int] = {}
        self._numbers: dict[tuple[Op, tuple[int, ...], object], int] = {}
        self._constants: dict[float, int] = {}  # number → its value
        self.serves = ""
        self.zero = self.constant(0.0)
        self.one = self.constant(1.0)
        self.minus_one = self.constant(-1.0)

    @classmethod
    def of(cls, values: Iterable[Value]) -> Self:
        """A graph that goes on from the values of a program, under the numbers that they have."""
        graph = cls()
        for value in values:
            graph.serves = value.serves
            graph._add(value.op, value.args, value.literal, value.origin)
        graph.serves = ""
        return graph

    def serving(self, name: str) -> "Setting":
        """Values first needed inside are credited to `name`."""
        return Setting(self, "serves", name)

    def _add(
        self, op: Op, args: tuple[int, ...], literal: Literal = None, origin: Folded | None = None
    ) -> int:
        if op in COMMUTATIVE and args[0] > args[1]:
            args = args[::-1]
        key = (op, args, literal)
        known = self._numbers.get(key)
        if known is not None:
            return known
        number = self._numbers[key] = len(self.values)
        self.values.append(_value(Value, (op, args, literal, self.serves, origin)))
        if literal is None:
            self.floats.append(None)
            self.settled.append(self._is_settled(args))
            return number
        self.floats.append(literal if op is Op.CONST else None)  # type: ignore[arg-type]
        if isinstance(literal, Input):
            self.settled.append(literal.array == "p")
            if not self.settled[number]:
                self.place_of(number)
        else:
            self.settled.append(op is not Op.MODE and self._is_settled(args))
        return number

    def _is_settled(self, args: tuple[int, ...]) -> bool:
        """Whether numbers and parameters determine all arguments."""
        for a in args:  # noqa: SIM110 (measured: `all` takes twice as long for two)
            if not self.settled[a]:
                return False
        return True

    def place_of(self, number: int) -> int:
        """The bit of an input in `movers`."""
        return self._places.setdefault(number, len(self._places))

    def count_as_moved_by(self, number: int, place: int) -> None:
        """Let a value count as moved by one input alone, whatever it is computed from."""
        moves = 1 << self.place_of(place)
        self._movers[number] = self._sets.setdefault(moves, moves)

    @property
    def moving_inputs(self) -> Sequence[int]:
        """The inputs but parameters."""
        return [*self._places]

    def movers(self, number: int) -> int:
        """The inputs but parameters that a value depends on, as bits of `place_of`."""
        known = self._movers
        moves = known.get(number)
        if moves is None:
            if all(a in known for a in self.values[number].args):
                moves = known[number] = self._moved_by(number)
                return moves
            for k in sorted(dependencies(self.values, [number], known)):
                if k not in known:
                    known[k] = self._moved_by(k)
            moves = known[number]
        return moves

    def _moved_by(self, number: int) -> int:
        """The movers of a value whose arguments' are known."""
        value, settled = self.values[number], self.settled[number]
        if isinstance(value.literal, Input):
            moves = 0 if settled else 1 << self.place_of(number)
        else:
            moves = reduce(or_, [self._movers[a] for a in value.args], 0)
        return self._sets.setdefault(moves, moves)

    # -- leaves ------------------------------------------------------------------------------

    def constant(self, number: float, sign: str = "", *numbers: float) -> int:
        """A number, or the result of the operation `sign` on `numbers`.

        Raises ModelError if it is not finite: the model multiplies or adds beyond all bounds.
        """
        known_number = self._constants.get(number)
        if known_number is not None:
            return known_number
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
        value = self._add(Op.CONST, (), float(number) + 0.0, origin)  # no negative zero
        self._constants[number] = value
        return value

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
        return self.floats[a]


class Setting:
    """An attribute of a graph with another value inside."""

    __slots__ = ("_before", "_graph", "_name", "_value")

    def __init__(self, graph: Numbering, name: str, value: object) -> None:
        self._graph, self._name, self._value = graph, name, value

    def __enter__(self) -> None:
        self._before = getattr(self._graph, self._name)
        setattr(self._graph, self._name, self._value)

    def __exit__(self, *failure: object) -> None:
        setattr(self._graph, self._name, self._before)
