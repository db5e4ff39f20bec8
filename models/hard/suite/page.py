"""The page of the hard cases: a table that says how each went, and one a case."""

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite

from models.hard.suite.case import KEPT, SHARE, WORTH, Case
from models.hard.suite.cell import DRIFTING, RESIDUAL, Cell, Verdict

HEAD = f"""# Hard cases

Machines that break multibody programs. Each is run by every method at several tolerances and
compared with a reference that no integrator of this program has made. A cell is *correct*, or it
ends with a *named outcome as expected* (so far only `REFUSED`, an error before the first step);
*stopped, by name* is a named end that was not expected.
A wrong cell that does not say so is marked **WRONG**, one that never ended **HANGS**.

How far from the reference may a right run be? An error made in one step grows like any
perturbation of the motion; the factor is a property of the machine and is stated with each case
(growth). At worst the errors of all steps add up: the bound is {SHARE:g} × steps × growth ×
rtol, with the steps of a method of order 8 at rtol 1e-9, and at least {KEPT:g} × growth × rtol.
A method of order p below 5 takes rtol^(1/5 - 1/p) times the steps of a method of order 5, and its
bound is larger by that factor.
Where the bound exceeds {WORTH:g} (m, rad, s) the number is beyond the horizon and not compared;
the column *until* gives the last instant that is compared, and where nothing can be compared the
verdict is *beyond the horizon*. |Φ| must stay below {RESIDUAL:.0e}; with the corrections
{" and ".join(DRIFTING)}, which only pull back or return now and then, it must stay below
{KEPT:g} × rtol.

| column | meaning |
|---|---|
| error, bound | the largest error against its bound, in the unit of the quantity |
| until | last instant that is compared, s |
| \\|Φ\\| | largest constraint residual at any output, m or rad |
| energy | largest departure from the balance of energy, over the largest kinetic energy |
| steps, rejected | accepted and rejected steps |
| parts | repartitions: changes of the independent coordinates |
| events | changes of modes |
| CPU | processor time of the integration and its outputs on one machine on one day, ms |
"""

ENDING = "*Written by `make hard`.*\n"

ROW = "| {} |"
OVERVIEW = (
    "| case | cells | correct | beyond | as expected | stopped | hangs | wrong |",
    "|---|--:|--:|--:|--:|--:|--:|--:|",
)
COLUMNS = (
    *("method", "correction", "rtol", "verdict", "error", "bound", "until", "\\|Φ\\|", "energy"),
    *("steps", "rejected", "parts", "events", "CPU"),
)
TABLE = (ROW.format(" | ".join(COLUMNS)), f"|---|---|---|---|{'--:|' * (len(COLUMNS) - 4)}")
ORDER = (
    Verdict.CORRECT,
    Verdict.BEYOND,
    Verdict.EXPECTED,
    Verdict.STOPPED,
    Verdict.HANGS,
    Verdict.WRONG,
)


def markdown(groups: Mapping[str, Sequence[Case]], cells: Sequence[Cell]) -> str:
    """The page; cases without cells are left out."""
    return "\n".join([HEAD, *_lines(groups, cells), ENDING])


def _lines(groups: Mapping[str, Sequence[Case]], cells: Sequence[Cell]) -> Iterator[str]:
    cases = [case for group in groups.values() for case in group]
    found = {case.name: [cell for cell in cells if cell.case == case.name] for case in cases}
    yield from OVERVIEW
    for case in cases:
        if found[case.name]:
            counts = [sum(cell.verdict == kind for cell in found[case.name]) for kind in ORDER]
            link = f"[{case.name}](#{case.name})"
            yield ROW.format(" | ".join([link, str(len(found[case.name])), *map(str, counts)]))
    yield ""
    for heading, group in groups.items():
        shown = [case for case in group if found[case.name]]
        if shown:
            yield f"## {heading}\n"
        for case in shown:
            yield from section(case, found[case.name])


def section(case: Case, cells: Sequence[Cell]) -> Iterator[str]:
    """A case: what it is, what to see, and its rows."""
    where = f"[{case.model}](../../models/{case.model}.py), scene `{case.scene}`"
    yield f"### {case.name}\n"
    yield f"{case.hard}\n"
    yield f"*What to see:* {case.see}\n"
    yield f"{where}, {case.t_end:g} s. Compared: {case.quantity}. Reference: {case.origin}.\n"
    worst = float(case.reference().bound(1.0).max())
    yield f"Bound at worst: {worst:.2g} × rtol.\n"
    yield from TABLE
    for cell in cells:
        yield row(cell)
    yield ""
    notes = [cell for cell in cells if cell.note]
    yield from (
        f"- {cell.method}, {cell.correction}, rtol {cell.rtol:.0e}: {cell.note}" for cell in notes
    )
    yield from [""] if notes else []


def row(cell: Cell) -> str:
    """A line of a case's table."""
    ended = cell.verdict in (Verdict.CORRECT, Verdict.BEYOND)
    verdict = str(cell.verdict) if ended else f"{cell.verdict}: {cell.outcome}"
    if cell.verdict in (Verdict.WRONG, Verdict.HANGS):
        verdict = f"**{cell.verdict}**"
    texts = (
        cell.method,
        cell.correction,
        f"{cell.rtol:.0e}",
        verdict,
        short(cell.error),
        short(cell.bound),
        f"{cell.until:.4g}" if isfinite(cell.until) else "–",
        short(cell.residual),
        short(cell.drift),
        str(cell.steps),
        str(cell.rejected),
        str(cell.repartitions),
        str(cell.events),
        f"{1e3 * cell.cpu:.3g}" if isfinite(cell.cpu) else "–",
    )
    return ROW.format(" | ".join(texts))


def short(value: float) -> str:
    """Two digits; a dash for what is no number."""
    if value == 0.0:
        return "0"
    return f"{value:.1e}" if isfinite(value) else "–"
