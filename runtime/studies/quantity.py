"""The quantity by which effects are ranked: a text, or a function of a result.

crank.phi              a series at the end: a coordinate, a velocity, a(crank.phi), a reaction
                       guide.fy, an energy (kinetic, potential, total), the power of an effect
max:guide.fy           a reduction of a series: max, min, peak, range, mean, rate, period
event:gas, event:gas#3 the instant of the first, or third, event of an effect, at which a joint
                       comes or goes, or a condition ends the run: event:latch, event:landed
count:gas              the number of its events
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.object_display import counted
from codegen.readers.values import finite_float
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import unknown
from runtime.results.motion_at_instants import with_both_sides
from runtime.results.result import Result

Function = Callable[[Result], float]
EVENTS = ("event", "count")
_OF_ENDS = ("end", "rate")  # reductions that take the first and last sample alone
_with_both_sides = lru_cache(maxsize=1)(with_both_sides)  # for all quantities of a result
_ALIKE = 0.25  # accuracy: of the bend at a maximum; a smaller one beside it tells a jump or a kink
_BESIDE = 1e-3  # layout: of a step between samples; nearer ones are on both sides of a jump


class Series(NamedTuple):
    """A function of time at instants, (k,) and (k,), two of them close together at each jump."""

    t: FloatArray
    x: FloatArray

    def jumps(self, near: slice) -> bool:
        """Whether samples on both sides of a jump are among these."""
        steps = np.diff(self.t[near])
        return bool(steps.min() < _BESIDE * steps.max())


def largest(series: Series) -> float:
    """The maximum: of the parabola about the largest sample if the curve bends alike beside it."""
    t, x = series
    k = int(np.argmax(x))
    if not 0 < k < len(x) - 1 or series.jumps(slice(k - 1, k + 2)):
        return float(x[k])
    first = k - 1 if k < 2 or series.jumps(slice(k - 2, k + 1)) else k - 2
    end = k + 2 if k > len(x) - 3 or series.jumps(slice(k, k + 3)) else k + 3
    steps = np.diff(t[first:end])
    slopes = np.diff(x[first:end]) / steps
    bends = np.diff(slopes) / (t[first + 2 : end] - t[first : end - 2])  # half of x''
    j = k - 1 - first
    if len(bends) < 2 or not (bends < _ALIKE * bends[j]).all() or bends[j] >= 0.0:
        return float(x[k])
    slope = np.average(slopes[j : j + 2], weights=steps[j : j + 2][::-1])  # of the parabola
    return float(x[k] - slope * slope / (4.0 * bends[j]))


def least(series: Series) -> float:
    """The minimum, in the same way."""
    return -largest(series._replace(x=-series.x))


def mean(series: Series) -> float:
    """The mean over time, by trapezoids."""
    t, x = series
    return float(np.trapezoid(x, t) / (t[-1] - t[0]))


def rate(series: Series) -> float:
    """The change over the time."""
    t, x = series
    return float((x[-1] - x[0]) / (t[-1] - t[0]))


def period(series: Series) -> float:
    """Mean time between upward crossings of the mean, each on the curve of four samples."""
    level = series.x - mean(series)
    (rises,) = np.nonzero((level[:-1] < 0.0) & (level[1:] >= 0.0))
    if len(rises) < 2:
        raise InputError(
            f"it crosses its mean upwards {counted(len(rises), 'time')} "
            "between the ends, which is not enough for a period; take a later end."
        )
    first, last = (_crossing(Series(series.t, level), int(k)) for k in (rises[0], rises[-1]))
    return (last - first) / (len(rises) - 1)


def _crossing(series: Series, k: int) -> float:
    """The instant between samples k and k + 1 at which it passes zero, by bisection."""
    t, x = series
    near = slice(max(k - 1, 0), min(k + 3, len(t)))
    low, high = float(t[k]), float(t[k + 1])
    if series.jumps(near):
        near = slice(k, k + 2)
    at = (t[near] - low) / (high - low)
    curve = np.polynomial.Polynomial.fit(at, x[near], len(at) - 1)
    a, b = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (a + b)
        a, b = (middle, b) if curve(middle) < 0.0 else (a, middle)
    return low + a * (high - low)


class Reduction(NamedTuple):
    """A reduction of a series to a number."""

    reduce: Callable[[Series], float]
    unit: str = "{}"  # by that of the series
    needs_span: bool = False  # whether one instant is not enough


REDUCTIONS = {
    "end": Reduction(lambda series: float(series.x[-1])),
    "max": Reduction(largest),
    "min": Reduction(least),
    "peak": Reduction(lambda series: max(largest(series), -least(series))),
    "range": Reduction(lambda series: largest(series) - least(series), needs_span=True),
    "mean": Reduction(mean, needs_span=True),
    "rate": Reduction(rate, "{}/s", needs_span=True),
    "period": Reduction(period, "s", needs_span=True),
}


class QuantityValue(NamedTuple):
    """The quantity of one result, its unit, and the largest magnitude of its series."""

    value: float
    unit: str
    scale: float


class Quantity(NamedTuple):
    """A quantity of results: of a reduction of a series, of events, or of a function."""

    text: str  # or the name of the function
    word: str  # a reduction, one of `EVENTS`, or "" of a function
    name: str = ""  # of the series, or of the effect
    number: int = 1  # of the event
    function: Function | None = None

    def read(self, result: Result) -> QuantityValue:
        """The value in a result; InputError where it has none."""
        if self.function is None:
            return (_event if self.word in EVENTS else _reduce)(self, result)
        value = self.function(result)
        number = finite_float(int(value) if isinstance(value, bool | np.bool_) else value)
        if number is None:
            raise InputError(
                f"{result.description.title}: {self.text} returns {value!r}; it must return a "
                "finite number."
            )
        return QuantityValue(number, "", abs(number))


def parse_quantity(given: str | Function) -> Quantity:
    """The quantity that a text or a function means; its series is looked up in the first result."""
    if callable(given):
        return Quantity(getattr(given, "__name__", "quantity"), "", function=given)
    text, words = given.strip(), [*REDUCTIONS, *EVENTS]
    if not text:
        raise InputError(
            f"The quantity is {given!r}; give a series such as crank.phi, or one with a word "
            f"before it ({', '.join(f'{word}:' for word in words)})."
        )
    word, name = text.split(":", 1) if ":" in text else ("end", text)
    if word not in words:
        raise InputError(f"{text}: {unknown('reduction', word, words)}")
    if word not in EVENTS:
        return Quantity(text, word, name.strip())
    effect, mark, digits = name.partition("#")
    if mark and not (digits.strip().isdigit() and int(digits) >= 1):
        raise InputError(f"{text}: after # stands the number of the event: 1, 2, 3 …")
    return Quantity(text, word, effect.strip(), int(digits or 1))


def declared_unit(given: str, description: Description) -> str:
    """The unit of a quantity's value, before there is a result.

    Raises InputError if the text means no quantity, or the scene has no such series or effect.
    """
    quantity = parse_quantity(given)
    if quantity.word in EVENTS:
        _changes(description, quantity.name)
        return "s" if quantity.word == "event" else ""
    return REDUCTIONS[quantity.word].unit.format(description.series.find(quantity.name).unit)


def _reduce(quantity: Quantity, result: Result) -> QuantityValue:
    reduction, where = REDUCTIONS[quantity.word], f"{result.description.title}, {quantity.text}:"
    x, unit = result.series(quantity.name)
    if len(x) < 2 and reduction.needs_span:
        raise InputError(f"{where} it takes more than one instant; ask for {quantity.name}.")
    if not np.isfinite(x).all():
        at = float(result.t[np.flatnonzero(~np.isfinite(x))[0]])
        raise InputError(f"{where} {quantity.name} is not a number at t = {at:g} s.")
    sides = _with_both_sides(result) if quantity.word not in _OF_ENDS else result
    t, rows = np.unique(sides.instants_of_states, return_index=True)
    at_sides = sides.series(quantity.name)[0][rows]
    known = np.isfinite(at_sides)  # it may not be in a singular position, which is an event
    try:
        value = reduction.reduce(Series(t[known], at_sides[known]))
    except InputError as error:
        raise InputError(f"{where} {error}") from None
    return QuantityValue(value + 0.0, reduction.unit.format(unit), float(np.abs(x).max()))


def _changes(description: Description, effect: str) -> bool:
    """Whether its events are the coming and going of a joint or condition; refuse one without."""
    rows = [row for row in description.watched if row.action != "sample"]
    changing = [row.target if row.reconnects else row.name for row in rows]
    names = dict.fromkeys([*description.switches.names, *changing])
    if effect not in names:
        text = unknown("effect with events", effect, names)
        raise UnknownNameError(f"{description.title}: {text}")
    return effect in changing


def _event(quantity: Quantity, result: Result) -> QuantityValue:
    description, effect, number = result.description, quantity.name, quantity.number
    times = [event.time for event in result.events if event.element == effect]
    if _changes(description, effect):  # beside events of the parts of its condition
        times = [change.time for change in result.reconnections if change.joint == effect]
        times += [float(result.t[-1])] if result.ended_by == effect else []
    count = len(times)
    if quantity.word == "count":
        return QuantityValue(float(count), "", float(count))
    if count < number:
        raise InputError(
            f"{description.title}: {effect} has {counted(count, 'event')} up to "
            f"t = {result.t[-1]:g} s, so there is no number {number}; take a later end."
        )
    return QuantityValue(times[number - 1], "s", float(result.t[-1]))
