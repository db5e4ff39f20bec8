"""The quantity that is asked for: a word, or a function of a result, made to a number.

crank.phi              a series at the end: a coordinate, a velocity, a(crank.phi), a reaction
                       guide.fy, an energy (kinetic, potential, total), the power of an effect
max:guide.fy           a reduction of a series: max, min, peak, range, mean, rate, period
event:gas, event:gas#3 the instant of the first, or third, event of an effect
count:gas              how many events it has
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from codegen.errors import InputError
from runtime.mechanism.description import unknown
from runtime.results.time_series import ENERGIES
from runtime.studies.effect_ranking.series_reductions import REDUCTIONS, Series

if TYPE_CHECKING:
    from runtime.mechanism.description import Description
    from runtime.results.result import Result

Function = Callable[["Result"], float]
EVENTS = {"event": "instant of an effect's first event, or of its third: event:gas#3",
          "count": "number of an effect's events"}  # fmt: skip
_LISTED = 24


class Reading(NamedTuple):
    """The quantity of one result, its unit, and the largest magnitude on the way to it."""

    value: float
    unit: str
    scale: float


class Quantity(NamedTuple):
    """What is asked of a result.

    Attributes
    ----------
    text
        As the user wrote it, or the name of the function.
    read
        Result → number; raises InputError where the result has no such quantity.
    """

    text: str
    read: Callable[["Result"], Reading]


def quantity(asked: str | Function) -> Quantity:
    """The quantity that a text or a function means.

    Raises
    ------
    InputError
        If the text is none; what its series is called is judged when a result is there.
    """
    if callable(asked):
        return Quantity(getattr(asked, "__name__", "quantity"), lambda r: _called(asked, r))
    text = _text(asked)
    word, colon, name = text.partition(":")
    if not colon:
        word, name = "end", text
    if word in EVENTS:
        number = _number(text, name)
        effect = name.partition("#")[0].strip()
        return Quantity(text, lambda result: _event(result, word, effect, number))
    if word not in REDUCTIONS:
        raise InputError(f"{text}: {unknown('reduction', word, [*REDUCTIONS, *EVENTS])}")
    return Quantity(text, lambda result: _reduced(result, text, word, name.strip()))


def names(told: "Description") -> dict[str, list[str]]:
    """Kind → names of the series that a scene's results have."""
    found = {
        "coordinates": [row.name for row in told.coordinates],
        "velocities": [row.velocity for row in told.coordinates],
        "accelerations": [f"a({row.name})" for row in told.coordinates],
        "reactions": list(told.reactions.names),
        "energies": list(ENERGIES) if told.has_masses and not told.unasked("energy") else [],
        "powers": list(told.powers.names),
    }
    return {kind: listed for kind, listed in found.items() if listed}


def _text(asked: object) -> str:
    text = asked.strip() if isinstance(asked, str) else ""
    if not text:
        raise InputError(f"The quantity is {asked!r}; give {_forms()}.")
    return text


def _forms() -> str:
    words = ", ".join(f"{word}:" for word in (*REDUCTIONS, *EVENTS))
    return f"a series such as crank.phi, or one with a word before it ({words})"


def _number(text: str, name: str) -> int:
    _, mark, digits = name.partition("#")
    if not mark:
        return 1
    if not digits.strip().isdigit() or int(digits) < 1:
        raise InputError(f"{text}: after # stands which event is meant: 1, 2, 3 …")
    return int(digits)


def _called(function: Function, result: "Result") -> Reading:
    value = function(result)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not np.isfinite(number):
        raise InputError(
            f"{result.description.title}: {getattr(function, '__name__', 'the function')} answers "
            f"{value!r}; it must answer a finite number."
        )
    return Reading(number, "", abs(number))


def _reduced(result: "Result", text: str, word: str, name: str) -> Reading:
    told = result.description
    try:
        x, unit = result.series(name)
    except InputError as error:
        known = names(told)
        listed = {*ENERGIES, *(n for of_kind in known.values() for n in of_kind)}
        if name in listed:  # it is there, and was not asked for
            raise
        raise InputError(f"{told.title}, {text}: {no_series(name, known)}") from error
    how = REDUCTIONS[word]
    if len(x) < 2 and not how.still:
        raise InputError(f"{told.title}, {text}: one instant has no {how.meaning}; ask for {name}.")
    if not np.isfinite(x).all():
        at = float(result.t[np.flatnonzero(~np.isfinite(x))[0]])
        raise InputError(f"{told.title}, {text}: {name} is not a number at t = {at:g} s.")
    jumps = np.array([event.time for event in result.events])
    try:
        value = how.reduce(Series(result.t, x, jumps))
    except InputError as error:
        raise InputError(f"{told.title}, {text}: {error}") from None
    return Reading(value + 0.0, how.unit.format(unit), float(np.abs(x).max()))


def no_series(name: str, known: dict[str, list[str]]) -> str:
    """Sentences saying that a series does not exist, with the nearest and all that there are.

    Parameters
    ----------
    known
        As `names` answers.
    """
    every = [n for listed in known.values() for n in listed]
    said = unknown("series", name, every)
    if "nearest" not in said:
        said = f"There is no series {name!r}."
    lists = []
    for kind, listed in known.items():
        rest = len(listed) - _LISTED
        more = f" and {rest} more" if rest > 0 else ""
        lists.append(f"{kind} {', '.join(listed[:_LISTED])}{more}")
    return f"{said} There are: {'; '.join(lists)}."


def _event(result: "Result", word: str, effect: str, number: int) -> Reading:
    told = result.description
    sources = list(dict.fromkeys(row.name for row in told.switches))
    if effect not in sources:
        raise InputError(f"{told.title}: {unknown('effect with events', effect, sources)}")
    times = [event.time for event in result.events if event.name.partition(":")[0] == effect]
    if word == "count":
        return Reading(float(len(times)), "", float(len(times)))
    if len(times) < number:
        raise InputError(
            f"{told.title}: {effect} has {len(times)} event{'' if len(times) == 1 else 's'} up to "
            f"t = {result.t[-1]:g} s, so there is no number {number}; take a later end."
        )
    return Reading(times[number - 1], "s", float(result.t[-1]))
