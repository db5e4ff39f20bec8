"""Series of a result by name: those that a scene has, their values, their magnitudes."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.mechanism.module_tables import Description
from runtime.mechanism.series_table import ENERGIES, quantity_of
from runtime.mechanism.table_rows import ReactionRow, unknown
from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]
OR = "|"  # between the names of a quantity of which a scene has one or another: ``a.x|b.x``
_LISTED = 24  # names of a kind that a message lists


def series_names(description: Description) -> dict[str, list[str]]:
    """Kind → names of the series that a scene's results have."""
    has_energy = description.has_masses and not description.leaves_out("energy")
    rows, effects = description.reactions, description.effects.names
    tracked = description.tracked
    sampled = description.sampled
    found = {
        "coordinates": [row.name for row in description.positions],
        "velocities": [row.velocity for row in description.positions],
        "accelerations": [f"a({row.name})" for row in description.positions],
        "states": [*description.states.names],
        "rates of states": [f"a({n})" for n in description.states.names if n not in sampled],
        "reactions": [row.name for row in rows if row.element not in effects],
        "quantities of effects": [
            row.name for row in rows if row.element in effects and row.element not in tracked
        ],
        "points": [row.name for row in rows if row.element in tracked],
        "energies": list(ENERGIES) if has_energy else [],
        "powers": list(description.whole_powers),
    }
    return {kind: listed for kind, listed in found.items() if listed}


def unknown_series(name: str, known: dict[str, list[str]]) -> str:
    """Sentences saying that a series does not exist: the nearest names; without any, all."""
    text = unknown("series", name, [one for listed in known.values() for one in listed])
    if "nearest" in text:
        return text
    text = f"There is no series {name!r}."
    lists = []
    for kind, listed in known.items():
        more = f" and {len(listed) - _LISTED} more" if len(listed) > _LISTED else ""
        lists.append(f"{kind} {', '.join(listed[:_LISTED])}{more}")
    return f"{text} There are: {'; '.join(lists)}."


def default_quantities(description: Description) -> tuple[str, ...]:
    """The coordinates that the scene starts from and their velocities, or all; and states."""
    fixed = {row.name for row in description.start if row.role == "fixed"}
    rows = [row for row in description.positions if fixed & {row.name, row.velocity}]
    rows = rows or [*description.positions]
    names = tuple(name for row in rows for name in (row.name, row.velocity))
    return names + description.states.names


def own_name(description: Description, name: str) -> str:
    """Of a quantity as outputs are written, ``force(strut)``, the name of its series; else `name`.

    A name of which there is no one series stays as it is.
    """
    word, _, rest = name.partition("(")
    element, closed = rest[:-1], rest.endswith(")")
    if closed and word == "power" and element in description.whole_powers:
        return element
    rows = [r for r in description.reactions if r.element == element and quantity_of(r) == word]
    whole = [row.name for row in rows if row.component == word or len(rows) == 1]
    return whole[0] if closed and len(whole) == 1 else name


def series_of(description: Description, quantities: Sequence[str]) -> tuple[str, ...]:
    """The series of the quantities: of names with ``|`` the first that exists, or InputError."""
    known = series_names(description)
    existing = {name for listed in known.values() for name in listed}
    series, problems = [], []
    for text in quantities:
        choices = [name.strip() for name in text.split(OR)]
        here = [name for name in (own_name(description, x) for x in choices) if name in existing]
        series += here[:1]
        problems += [] if here else [f"{description.title}: {unknown_series(choices[0], known)}"]
    if problems:
        raise InputError(problems)
    return tuple(series)


def distinct_quantities(description: Description, quantities: Sequence[str]) -> tuple[str, ...]:
    """The quantities as they are written; of those that are the same series, the first."""
    texts: dict[str, str] = {}
    for series, text in zip(series_of(description, quantities), quantities, strict=True):
        texts.setdefault(series, text)
    return tuple(texts.values())


def series_values(result: Result, names: Sequence[str]) -> FloatArray:
    """The series as columns, (k, j)."""
    columns = [result.series(name)[0] for name in names]
    return np.stack(columns, axis=1) if columns else np.zeros((len(result.t), 0))


def require_numbers(description: Description, names: Sequence[str], values: FloatArray) -> None:
    """Refuse series without a finite value in (k, j), whose error would otherwise count as 0."""
    finite = np.isfinite(values)
    without = [name for j, name in enumerate(names) if not finite[:, j].any()]
    if without and len(values):
        raise InputError(
            f"{description.title}: {name} is no number at any of the {len(values)} output "
            "instants, so it has no error. Leave it out, or correct its definition."
            for name in without
        )


def magnitude(values: FloatArray) -> float:
    """Largest magnitude of the finite values."""
    return float(np.abs(np.where(np.isfinite(values), values, 0.0)).max(initial=0.0))


def group_magnitude(result: Result, name: str) -> float:
    """Largest magnitude in a run of the whole that a series is a part of; 0 of other series.

    The total energy of a machine without losses is zero or nearly so where the potential is counted
    from a convenient height, and a bearing may carry nothing in one direction: such a series is
    rounding, which cannot be measured by itself. Energies are measured by all energies, the
    components of a joint's or an effect's force by the whole force.
    """
    if name in ENERGIES:
        return magnitude(result.samples.energy)
    rows, effects = result.description.reactions, result.description.effects.names
    if name not in rows.names:
        return 0.0

    def group(row: ReactionRow) -> tuple[str, ...]:
        return row.element, row.unit, quantity_of(row) if row.element in effects else ""

    own = group(rows[name])
    return max(
        magnitude(result.samples.reaction[:, k]) for k, row in enumerate(rows) if group(row) == own
    )
