"""The quantity by which effects are ranked: a text, or a function of a result.

crank.phi              a series at the end: a coordinate, a velocity, a(crank.phi), a reaction
                       guide.fy, an energy (kinetic, potential, total), the power of an effect
max:guide.fy           a reduction of a series: max, min, peak, range, mean, rate, period
event:gas, event:gas#3 the instant of the first, or third, event of an effect
count:gas              the number of its events
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from codegen.errors import InputError
from runtime.mechanism.description import unknown
from runtime.results.time_series import ENERGIES
from runtime.studies.effect_ranking.series_reductions import REDUCTIONS, Series
from runtime.studies.series import series_names, unknown_series

if TYPE_CHECKING:
    from runtime.results.result import Result

Function = Callable[["Result"], float]
EVENTS = {"event": "instant of an effect's first event, or of its third: event:gas#3",
          "count": "number of an effect's events"}  # fmt: skip


class QuantityValue(NamedTuple):
    """The quantity of one result, its unit, and the largest magnitude of its series."""

    value: float
    unit: str
    scale: float


class Quantity(NamedTuple):
    """A quantity of results.

    Attributes
    ----------
    text
        As the user wrote it, or the name of the function.
    read
        Result → number; raises InputError where the result has no such quantity.
    """

    text: str
    read: Callable[["Result"], QuantityValue]


def parse_quantity(text: str | Function) -> Quantity:
    """The quantity that a text or a function means.

    Raises
    ------
    InputError
        If the text is none; the name of its series is checked against the first result.
    """
    if callable(text):
        return Quantity(getattr(text, "__name__", "quantity"), lambda r: _call(text, r))
    given: object = text
    stripped = given.strip() if isinstance(given, str) else ""
    if not stripped:
        words = ", ".join(f"{word}:" for word in (*REDUCTIONS, *EVENTS))
        raise InputError(
            f"The quantity is {text!r}; give a series such as crank.phi, or one with a word before "
            f"it ({words})."
        )
    word, colon, name = stripped.partition(":")
    if not colon:
        word, name = "end", stripped
    if word in EVENTS:
        number = _event_number(stripped, name)
        effect = name.partition("#")[0].strip()
        return Quantity(stripped, lambda result: _event(result, word, effect, number))
    if word not in REDUCTIONS:
        raise InputError(f"{stripped}: {unknown('reduction', word, [*REDUCTIONS, *EVENTS])}")
    return Quantity(stripped, lambda result: _reduce(result, stripped, word, name.strip()))


def _event_number(text: str, name: str) -> int:
    _, mark, digits = name.partition("#")
    if not mark:
        return 1
    if not digits.strip().isdigit() or int(digits) < 1:
        raise InputError(f"{text}: after # stands the number of the event: 1, 2, 3 …")
    return int(digits)


def _call(function: Function, result: "Result") -> QuantityValue:
    value = function(result)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not np.isfinite(number):
        raise InputError(
            f"{result.description.title}: {getattr(function, '__name__', 'the function')} returns "
            f"{value!r}; it must return a finite number."
        )
    return QuantityValue(number, "", abs(number))


def _reduce(result: "Result", text: str, word: str, name: str) -> QuantityValue:
    title = result.description.title
    try:
        x, unit = result.series(name)
    except InputError as error:
        known = series_names(result.description)
        if name in {*ENERGIES, *(one for listed in known.values() for one in listed)}:
            raise  # the scene has it, compiled without its output
        raise InputError(f"{title}, {text}: {unknown_series(name, known)}") from error
    how = REDUCTIONS[word]
    if len(x) < 2 and not how.still:
        raise InputError(f"{title}, {text}: one instant has no {how.meaning}; ask for {name}.")
    if not np.isfinite(x).all():
        at = float(result.t[np.flatnonzero(~np.isfinite(x))[0]])
        raise InputError(f"{title}, {text}: {name} is not a number at t = {at:g} s.")
    jumps = np.array([event.time for event in result.events])
    try:
        value = how.reduce(Series(result.t, x, jumps))
    except InputError as error:
        raise InputError(f"{title}, {text}: {error}") from None
    return QuantityValue(value + 0.0, how.unit.format(unit), float(np.abs(x).max()))


def _event(result: "Result", word: str, effect: str, number: int) -> QuantityValue:
    description = result.description
    effects = list(dict.fromkeys(row.name for row in description.switches))
    if effect not in effects:
        raise InputError(f"{description.title}: {unknown('effect with events', effect, effects)}")
    times = [event.time for event in result.events if event.name.partition(":")[0] == effect]
    count = len(times)
    if word == "count":
        return QuantityValue(float(count), "", float(count))
    if count < number:
        raise InputError(
            f"{description.title}: {effect} has {count} event{'' if count == 1 else 's'} up to "
            f"t = {result.t[-1]:g} s, so there is no number {number}; take a later end."
        )
    return QuantityValue(times[number - 1], "s", float(result.t[-1]))
