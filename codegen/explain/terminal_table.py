"""Ledgers on a terminal: a part a row, no wider than a person reads."""

import shutil
from collections.abc import Callable, Iterator, Sequence

from rich.table import Table

from codegen.explain.ledger_data import Ledger, Part
from codegen.explain.scene_comparison import Comparison

NARROW, WIDE, UNKNOWN = 80, 140, 120
"""Columns that a table has at least and at most, and where nothing says how wide the screen is."""


def width() -> int:
    """Columns of the terminal, within what a table is made for."""
    return min(max(shutil.get_terminal_size((UNKNOWN, 24)).columns, NARROW), WIDE)


Column = tuple[str, Callable[[Part], str]]


def table(ledger: Ledger) -> Table:
    """What is in, with its costs, and what is out, with the reason."""
    made = Table(title=f"{ledger.model}, scene {ledger.scene}")
    made.add_column("part", no_wrap=True, max_width=24)
    made.add_column("", no_wrap=True)
    made.add_column("why", overflow="fold", ratio=1)
    columns = _columns(ledger)
    for title, _ in columns:
        made.add_column(title, justify="right", no_wrap=True)
    for section in _sections(ledger):
        for part in section:
            texts = (show(part) for _, show in columns)
            reason = part.kind if part.role == "shared" else f"{part.kind}; {part.why}"
            made.add_row(part.name, "in" if part.acts else "out", reason, *texts)
        made.add_section()
    made.add_row("total", "", "", *(_total(ledger, title) for title, _ in columns))
    return made


def run_table(ledger: Ledger) -> Table:
    """What a run spent on each part that took any of it."""
    made = Table("part", title=f"{ledger.model}, scene {ledger.scene}: the run")
    whole = ledger.run.seconds if ledger.run else 0.0
    for title in ("events", "steps again", "µs", "% of the run"):
        made.add_column(title, justify="right", no_wrap=True)
    spent = [part for part in ledger.parts if part.run_seconds or part.run_events]
    rest = whole - sum(part.run_seconds or 0.0 for part in spent)
    for part in spent:
        again = _count(round(part.run_retakes or 0.0))
        costs = _microseconds(part.run_seconds or 0.0, whole)
        made.add_row(part.name, _count(part.run_events or 0), again, *costs)
    made.add_section()
    made.add_row("all other work of the run", "", "", *_microseconds(rest, whole))
    if ledger.run is not None:
        counts = str(ledger.run.events), str(ledger.run.retakes)
        made.add_row("total", *counts, *_microseconds(whole, whole))
    return made


def _microseconds(seconds: float, whole: float) -> tuple[str, str]:
    return f"{1e6 * seconds:.1f}", f"{100 * seconds / whole:.2f}" if whole else ""


def matrix(ledger: Ledger) -> Table:
    """Operations of every part in every kernel."""
    made = Table("part", "kind", title=f"{ledger.model}, scene {ledger.scene}: operations")
    for kernel in ledger.kernels:
        made.add_column(kernel, justify="right")
    for part in ledger.parts:
        if part.acts and part.role != "fidelity":
            counts = (str(part.operations.get(k, "")) for k in ledger.kernels)
            made.add_row(part.name, part.kind, *counts)
    made.add_section()
    made.add_row("total", "", *(str(ledger.totals[k]) for k in ledger.kernels))
    return made


def notes(ledger: Ledger) -> Iterator[str]:
    """What a table has no room for, a line each."""
    told = [entry.name for entry in ledger.outputs if entry.asked]
    yield f"outputs: {', '.join(told) or 'the motion alone'}"
    silent: dict[str, list[str]] = {}
    for entry in ledger.outputs:
        if not entry.asked:
            silent.setdefault(entry.why, []).append(entry.name)
    for why, names in silent.items():
        yield f"without {', '.join(names)}: {why}"
    if ledger.nanoseconds is not None:
        parts = sum(part.nanoseconds or 0.0 for part in ledger.parts)
        off = parts - ledger.nanoseconds
        part = 100 * off / ledger.nanoseconds if ledger.nanoseconds > 0.0 else 0.0
        yield (
            f"an evaluation of accelerations, timed by itself: {ledger.nanoseconds:.1f} ns; its "
            f"parts add up to {parts:.1f} ns ({off:+.1f} ns, {part:+.1f} %)"
        )
    if ledger.run is not None:
        took = ledger.run
        yield (
            f"a run of {took.t_end:g} s: {took.evaluations} evaluations in {took.steps} steps, "
            f"{took.rejected} more refused and {took.retakes} taken again for {took.events} "
            f"events, in {1e3 * took.seconds:.3g} ms"
        )


def compared(comparison: Comparison) -> Table:
    """Two scenes side by side, and what the second has more."""
    first, second = comparison.first, comparison.second
    made = Table(title=f"{first.model}: A = {first.scene}, B = {second.scene}")
    made.add_column("part", overflow="fold")
    timed = first.nanoseconds is not None or second.nanoseconds is not None
    for what in ("in", "accelerations", "all kernels", *(["ns"] if timed else [])):
        short = {"accelerations": "acc.", "all kernels": "all"}.get(what, what)
        for side in ("A", "B"):
            made.add_column(f"{short} {side}", justify="right", no_wrap=True)
        if what != "in":
            made.add_column("B-A", justify="right", no_wrap=True)
    rows = [*comparison.rows, None]
    for row in rows:
        found = row or comparison.total
        if row is None:
            made.add_section()
        texts = [_sided(found.acts, lambda x: "in" if x else "out")] if row else [["", ""]]
        texts += [_pair(found.accelerations), _pair(found.operations)]
        texts += [_pair(found.nanoseconds)] if timed else []
        made.add_row(found.name, *(text for pair in texts for text in pair))
    return made


def _sided(pair: tuple[object, object], show: Callable[[object], str]) -> list[str]:
    return ["-" if side is None else show(side) for side in pair]


def _pair(pair: tuple[float | None, float | None]) -> list[str]:
    """Both values and their difference; what is nothing in both is left blank."""
    if not any(pair):
        return ["", "", ""]
    change = (pair[1] or 0) - (pair[0] or 0)
    return [*(_number(side) for side in pair), _number(change, sign="+") if change else "="]


def _number(value: float | None, sign: str = "") -> str:
    if value is None:
        return ""
    return f"{value:{sign}d}" if isinstance(value, int) else f"{value:{sign}.1f}"


def _sections(ledger: Ledger) -> Iterator[Sequence[Part]]:
    inside = [part for part in ledger.parts if part.acts]
    yield [part for part in inside if part.role != "shared"]
    yield [part for part in inside if part.role == "shared"]
    yield [part for part in ledger.parts if not part.acts]


def _columns(ledger: Ledger) -> list[Column]:
    found: list[Column] = [
        ("acc.", lambda part: _count(part.operations.get("accelerations", 0))),
        ("all", lambda part: _count(sum(part.operations.values()))),
    ]
    if ledger.nanoseconds is not None:
        found.append(("ns", lambda part: _number(part.nanoseconds or None)))
    found.append(("events", lambda part: _count(len(part.events))))
    return found


def _count(number: int) -> str:
    return str(number) if number else ""


def _total(ledger: Ledger, title: str) -> str:
    if title == "acc.":
        return str(ledger.totals.get("accelerations", 0))
    if title == "all":
        return str(sum(ledger.totals.values()))
    if title == "ns":
        return f"{sum(part.nanoseconds or 0.0 for part in ledger.parts):.1f}"
    return str(sum(len(part.events) for part in ledger.parts))
