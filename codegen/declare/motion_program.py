"""Motion programs: rises, dwells and falls one after the other, as functions of an angle or a time.

A program is one formula whose numbers are chosen by the piece, s = a + h (c0 + c1 u + … + A sin(ω u
+ φ)) with u from 0 to 1 in each move, so that a kernel has one sine for all pieces.
"""

from collections.abc import Mapping, Sequence
from functools import reduce
from hashlib import sha256
from itertools import accumulate
from math import inf, pi
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy

from codegen.declare.body import expressions_in
from codegen.declare.symbols import Given, alpha
from codegen.declare.value_reader import Reader
from codegen.errors import ModelError
from codegen.readers.arguments import count, reads
from codegen.readers.calls import declaring, declaring_class
from codegen.readers.expressions import plain_expression
from codegen.readers.quantities import converted, known_unit, si_unit
from codegen.readers.values import KindError, members, plain_float, shown
from codegen.tables.motion_laws import LIMITED, SHAPES, Piece, fastest, pieces
from codegen.tables.piecewise_function import close
from codegen.tables.table_function import other_dimension, plain_function

_TURN = 2.0 * pi  # formula: rad
_CLOSED = 1e-9  # accuracy: turns; of the length of a program from one turn
_DWELL = Piece(1.0, 0.0, 0.0, 0.0, (0.0,) * 8)


Move = tuple[float, sympy.Expr, sympy.Expr, tuple[Piece, ...]]
"""Length, first and last value, in SI units, and the pieces of its law."""


@declaring_class("MotionProgram")
class MotionProgram:
    """Moves as a function: called with an expression, it returns the value there."""

    def __init__(self, moves: Sequence[Move], unit: str, of: str, periodic: bool) -> None:
        self.unit, self.value_unit, self.length = unit, of, sum(length for length, *_ in moves)
        self._at, self._scale, scale = Given("place", real=True), sympy.S.One, 1.0
        if periodic:  # a turn of alpha
            self._at, scale = alpha, _TURN / self.length
            self._scale = sympy.S.One if unit == "rad" else sympy.Float(scale)
        else:  # values are kept before and behind
            before, behind = ((0.0, v, v, (_DWELL,)) for v in (moves[0][1], moves[-1][2]))
            moves = [before, *moves, behind]
        formula = _formula(moves, self._at, scale)
        digest = sha256(str(formula).encode()).hexdigest()
        self._function = close(formula, f"motion_{digest[:12]}")

    @declaring("MotionProgram")
    def __call__(self, at: Any) -> sympy.Expr:
        """The value at `at`: t, `alpha`, coordinates or parameters, in SI units, or a quantity."""
        (place,) = expressions_in(self.unit, repr(self), at)
        if other := other_dimension(place, self.unit):
            raise ModelError(
                f"{self!r} is called with {shown(at)}, in {other}; give it what is in {self.unit}, "
                "or the program other units=."
            )
        return self._function.xreplace({self._at: self._scale * place})

    @reads(order=count(0))
    def values(self, at: Any, order: int = 0, parameters: Any = None) -> npt.NDArray[np.float64]:
        """The value, or a derivative by the angle or time, at a number or an array of them, SI.

        `order` 1 is the velocity, 2 the acceleration, 3 the jerk; `parameters` are those of the
        program, by name or symbol.
        """
        place = Given("at", real=True)
        derivative = self(place).diff(place, order)
        return np.asarray(values_of([derivative], place, at, parameters, repr(self))[0])

    def __repr__(self) -> str:
        return f"motion program over {self.length:.6g} {self.unit}"


def values_of(
    expressions: Sequence[sympy.Expr], symbol: sympy.Symbol, at: Any,
    parameters: Mapping[Any, Any] | None, where: str,
) -> npt.NDArray[np.float64]:  # fmt: skip
    """Values of expressions, along the first axis, at numbers for a symbol."""
    given = {str(name): value for name, value in (parameters or {}).items()}
    own = sorted(sympy.Tuple(*expressions).free_symbols - {symbol}, key=str)
    if missing := [s.name for s in own if s.name not in given]:
        raise ModelError(f"{where} depends on {', '.join(missing)}; give parameters={{...}}.")
    function = plain_function([symbol, *own], [*expressions])
    numbers = [plain_float(given[s.name]) for s in own]
    try:
        places = np.asarray(at, dtype=np.float64)
    except (TypeError, ValueError):
        raise ModelError(f"{where}: {shown(at)}: give plain numbers, in SI units.") from None
    rows = [function([x, *numbers]) for x in places.ravel().tolist()]
    return np.reshape(np.transpose(rows), (len(expressions), *places.shape))


@declaring("motion_program")
def motion_program(
    moves: Any, start: Any = 0, units: tuple[str, str] = ("rad", "m"), limits: Any = (),
    periodic: bool = True,
) -> MotionProgram:  # fmt: skip
    """A function of moves and dwells: the lift of a cam over its angle, a law of motion over time.

    Called with an expression, ``lift(cam.phi)``, ``lift(lw.alpha)`` or ``stroke(lw.t)``, it may
    stand in laws, forces, constraints and profiles. Steps end where pieces meet.

    Parameters
    ----------
    moves
        ``(length, value, law)`` each: within an angle or a time the function goes to a value, from
        rest to rest. ``(length, value)`` with the value before is a dwell. The laws are
        ``"harmonic"``, ``"cycloid"``, ``"3-4-5"``, ``"4-5-6-7"``, ``"modified sine"``,
        ``"modified trapezoid"``, and, with the length None and `limits`, ``"trapezoidal"`` and
        ``"S-curve"``, which are as fast as these allow. Values may depend on parameters.
    start
        The value before the first move.
    units
        Of the numbers of lengths and values: ``("deg", "mm")``, ``("s", "rad")``.
    limits
        The largest speed, acceleration and jerk, in `units`: value per length, length², length³.
    periodic
        Whether the moves repeat; the last one then returns to the start, and over an angle they
        take a turn together: ``lift(3 * cam.phi)`` has three cycles a turn. Otherwise the first and
        the last value are kept before and after.
    """
    read, made = Reader(), list[Move]()
    try:
        rows, bounds = [members(move) for move in members(moves)], members(limits)
        if not (rows and {*map(len, rows)} <= {2, 3} and all(map(known_unit, members(units, 2)))):
            raise KindError
    except KindError:
        raise ModelError(
            f"motion_program: moves={shown(moves)}, units={shown(units)}, limits={shown(limits)}; "
            "write [(1.5, 0.02, 'cycloid'), ...], ('rad', 'm'), (speed, acceleration, jerk)."
        ) from None
    (x, y), (over, of) = units, map(si_unit, units)

    def positive(value: Any, given: str, unit: str, where: str) -> float:
        number = read.number(value, given, where)
        if not 0.0 < number < inf:
            read.note(f"{where} is {shown(value)}; give a number that is more than 0.")
            number = 1.0
        return float(converted(number, given, unit))

    def expression(value: Any, where: str) -> sympy.Expr:
        found = read.value(value, y, where)
        return plain_expression(converted(float(found), y, of)) if found.is_number else found

    most = [positive(v, f"{y}/{x}^{k}", f"{of}/{over}^{k}", f"limits[{k - 1}]")
            for k, v in enumerate(bounds, 1)]  # fmt: skip
    begin = first = expression(start, "start")
    for k, row in enumerate(rows):
        where = f"moves[{k}]"
        last = expression(row[1], f"{where}, value")
        name = read.choice(row[2], (*SHAPES, *LIMITED), f"{where}, law") if row[2:] else ""
        if (needed := LIMITED.get(name, 0)) == 0:
            if not name and first != last:
                read.note(f"{where} goes to {shown(row[1])} without a law; name one, as 'cycloid'.")
            law = pieces(SHAPES[name]) if name and first != last else (_DWELL,)
            made.append((positive(row[0], x, over, f"{where}, length"), first, last, law))
        elif row[0] is None and len(most) >= needed and (last - first).is_nonzero:
            length, law = fastest(abs(float(last - first)), *[*most[:needed], inf][:3])
            made.append((length, first, last, law))
            if law[0].polynomial[1]:  # no ramp is left
                read.note(f"{where} takes 1e12 times as long as its ramps; change limits=.")
        else:
            read.note(
                f"{where}: write (None, value, {name!r}), with a value that is another number, and "
                f"{needed} limits= that decide how long it takes, speed, acceleration, jerk."
            )
        first = last
    turns, ends = sum(length for length, *_ in made) / _TURN, f"ends at {shown(rows[-1][1])}"
    if periodic and first != begin:
        read.note(f"it begins at {shown(start)} and {ends}; return, or give periodic=False.")
    if periodic and over == "rad" and abs(1.0 - turns) > _CLOSED:
        read.note(f"the moves take {360.0 * turns:.6g}°, not 360°; change a dwell.")
    if read.problems:
        raise ModelError(f"motion_program: {read.problems[0]}")
    return MotionProgram(made, over, of, periodic)


def _formula(moves: Sequence[Move], at: sympy.Symbol, scale: float) -> sympy.Expr:
    """s(at), where lengths are those of the moves times a scale."""
    ends, rows = list[float](), list[list[Any]]()  # None does not matter
    begin = 0.0
    for length, first, last, law in moves:
        for end, amplitude, *wave, powers, since in law:
            ends.append(begin + end * length * scale)
            sine = (amplitude, *wave) if amplitude else (0.0, None, None)
            moving = [begin + since * length * scale, 1.0 / (length * scale or 1.0), *sine, *powers]
            rows.append([first, last - first, *(moving if first != last else [None] * 13)])
        begin += length * scale

    def chosen(column: Sequence[Any]) -> sympy.Expr:
        """The number of each piece; one that does not matter is that of a neighbour."""
        known = next((v for v in column if v is not None), sympy.S.Zero)
        kept: list[Any] = [*accumulate([known, *column], lambda a, b: a if b is None else b)][1:]
        changes = [k for k in range(1, len(kept)) if kept[k] != kept[k - 1]]
        parts = [(kept[k - 1], at < ends[k - 1]) for k in changes]
        return sympy.Piecewise(*parts, (kept[-1], True))

    base, lift, start, rate, size, frequency, phase, *c = map(chosen, zip(*rows, strict=True))
    u = (at - start) * rate
    polynomial = reduce(lambda value, power: value * u + power, reversed(c))
    return base + lift * (polynomial + size * sympy.sin(frequency * u + phase))


@declaring("fourier_series")
def fourier_series(
    at: Any, mean: Any = 0, cosines: Any = (), sines: Any = (), period: Any = 2 * sympy.pi
) -> sympy.Expr:
    """Return mean + Σ a_k cos(2πk at / period) + b_k sin(2πk at / period), k = 1, 2, ….

    `at` is the time, an angle or `alpha`; `cosines` and `sines` are a_k and b_k, numbers or
    expressions of parameters, in SI units.
    """
    try:
        mean, over, once = map(plain_expression, (mean, at, period))
        waves = [plain_expression(c) * wave(k * (2 * sympy.pi * over / once))
                 for row, wave in ((cosines, sympy.cos), (sines, sympy.sin))
                 for k, c in enumerate(members(row), 1)]  # fmt: skip
        if once == 0:
            raise KindError
    except KindError:
        what = f"mean, cosines, sines and period are {shown((mean, cosines, sines, period))}"
        raise ModelError(f"fourier_series: {what}; write 1.0, [0.5], [0.1, 0.3], 0.4.") from None
    return sympy.Add(mean, *waves)
