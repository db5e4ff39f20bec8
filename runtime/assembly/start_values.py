"""Start values of a run: the scene's, or the user's in their place, and how far they were moved."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import AssemblyError
from codegen.object_display import with_unit, without_rounding
from codegen.readers.values import finite_float, shown
from runtime.assembly.start_spins import Spin
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.mechanism import Mechanism, Numbers
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import unknown
from runtime.results.assembled_state import Assembly, State

BoolArray = npt.NDArray[np.bool_]

# accuracy: ease of what a joint counts and nobody gives, so that it follows from its bodies; they
# feel it by the inverse square, and rounding grows by it
_FOLLOWS = 2.0**17
MOVED = 1e-9  # accuracy: change of a start value, relative to its size, that is reported


class Start(NamedTuple):
    """Start values as arrays, whether they are fixed, and whether they are given; each (n,)."""

    q: FloatArray
    v: FloatArray
    fixed_q: BoolArray
    fixed_v: BoolArray
    given_q: BoolArray
    ease: FloatArray  # (2, n): how easily q and v change, beside typical sizes
    spins: tuple[Spin, ...] = ()  # what holds of ω' of bodies in space


def start_values(
    mechanism: Mechanism, guess: Numbers | None, fixed_values: Numbers | None = None, *,
    release: bool = False,
) -> Start:  # fmt: skip
    """The scene's start values, with the user's in place of those of the same name.

    Those of `fixed_values` are kept, as those that the scene fixes, which no guess may name. With
    `release`, nothing is fixed and velocities are zero, but for states: a guess may name all
    positions and states, and no velocity.
    """
    description = mechanism.description
    table, n = description.coordinates, len(description.coordinates)
    places = {row.velocity: (1, k) for k, row in enumerate(table)}
    places |= {row.name: (0, k) for k, row in enumerate(table)}
    values = np.array([description.neutral, np.zeros(n)])
    fixed, named = np.zeros((2, 2, n), np.bool_)
    spins = {r.name: r.value for r in description.start if r.name in description.spins}
    spins |= {name: x for name, x in (fixed_values or {}).items() if name in description.spins}
    for row in description.start:
        if row.role != "neutral" and row.name not in spins:
            place = places[row.name]
            values[place], fixed[place], named[place] = row.value, row.role == "fixed", True
    problems, fixed_names = [], dict[str, float]()
    states = np.isin(np.arange(n), [state.column for state in description.states])
    given = [(name, value, False) for name, value in (guess or {}).items()]
    given += [(name, value, True) for name, value in (fixed_values or {}).items()]
    problems += _spin_problems(description, guess or {})
    for name, value, kept in given:
        finite = finite_float(value)
        if name in description.spins and (finite is not None or not kept):
            continue
        if name not in description.startable:
            what = "coordinate or velocity"
            what = "coordinate, velocity or state" if description.states else what
            counting = description.suggest_counting(str(name))
            problems.append(counting or unknown(what, name, description.startable))
        elif finite is None:
            problems.append(f"Start value {name} is {shown(value)}; it must be a finite number.")
        elif release and places[name][0] and not states[places[name][1]]:
            problems.append(
                f"{description.title}: {name} is a velocity, and at rest all of them are zero. "
                "Leave it out of guess."
            )
        elif fixed[places[name]] and not (kept or release):
            fixed_names[name] = finite
        else:
            values[places[name]], named[places[name]] = finite, True
            fixed[places[name]] |= kept
    if fixed_names:
        problems.append(_refusal(description, fixed_names))
    if problems:
        raise AssemblyError(problems)
    ease = np.where((mechanism.shape["counted"] > 0) & ~named, _FOLLOWS, 1.0)
    if release:
        none = np.zeros(n, np.bool_)
        return Start(values[0], np.where(states, values[1], 0.0), none, none.copy(), named[0], ease)
    rows = tuple(Spin(name, *description.spins[name], x) for name, x in spins.items())
    return Start(values[0], values[1], fixed[0], fixed[1], named[0], ease, rows)


def _spin_problems(description: Description, guess: Numbers) -> list[str]:
    """Angular velocities that are only guessed."""
    guessed = [row.name for row in description.start if row.role == "guess"]
    names = [name for name in (*guessed, *guess) if name in description.spins]
    text = (
        f"{description.title}: guess names {', '.join(names)}, an angular velocity; give it in "
        "start=, or guess the rates of Euler parameters."
    )
    return [text] if names else []


def _refusal(description: Description, guess: Numbers) -> str:
    """The problem of guesses, all of which name what the scene fixes."""
    series = description.series
    scene = ", ".join(
        f"{row.name} = {with_unit(row.value, series.find(row.name).unit)}"
        for row in description.start
        if row.role == "fixed" and row.name in guess
    )
    return (
        f"{description.title}: guess names what the scene fixes: {scene}. A guess only begins a "
        f"search: give start={dict(guess)} (--start) to set {'them' if len(guess) > 1 else 'it'}."
    )


def start_of_state(state: Assembly | State) -> Start:
    """All values of a state, none of them fixed."""
    free = np.zeros(len(state.q), np.bool_)
    return Start(state.q.copy(), state.v.copy(), free, free.copy(), ~free, np.ones((2, len(free))))


def start_note(
    mechanism: Mechanism, begin: Assembly, guess: Numbers | None, given: Numbers | State | None
) -> str:
    """Sentences on what became of the start values and guesses of a user."""
    description, parts = mechanism.description, list[str]()
    if isinstance(given, State):
        moved = ", ".join(f"{m.name} by {m.by:.3g} {m.unit}" for m in begin.moved)
        parts.append(
            f"It starts from a state at t = {given.t:.9g} s"
            f"{f' of scene {given.scene!r}' if given.scene else ''}"
            f"{f', which joints and drivers moved ({moved})' if moved else ''}."
        )
    elif given:
        kept = (
            f"{name} = {with_unit(value, description.series.find(name).unit)}"
            for name, value in given.items()
        )
        parts.append(f"start sets {', '.join(kept)}.")
    for name, value in (guess or {}).items():
        if abs(begin[name] - value) > MOVED * max(1.0, abs(value)):
            unit = description.series.find(name).unit
            set_others = "" if isinstance(given, State) else ", ".join(given or ())
            why = f", with start of {set_others}" if set_others else ": start= sets a value"
            reached = with_unit(without_rounding((begin[name], value))[0], unit)
            parts.append(f"guess {name} = {value:.6g} became {reached}{why}.")
    return "".join(f" {part}" for part in (*parts, *filter(None, (begin.note,))))
