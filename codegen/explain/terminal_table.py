"""Ledgers on a terminal: a part a row, no wider than a person reads."""

from collections.abc import Iterator

from rich.console import Console
from rich.table import Table

from codegen.explain.ledger import Comparison, Ledger, Part, RunCosts
from codegen.presentation import terminal_width

PAPER = 1000  # columns of a table that is as wide as its content, whatever the terminal


def show(ledgers: tuple[Ledger, ...], comparison: Comparison | None, *, kernels: bool) -> None:
    """Print the ledgers, or their comparison, on stdout; with `kernels` also the wide tables."""
    screen = Console(width=terminal_width(), highlight=False)
    if comparison is not None:
        screen.print(comparison_table(comparison))
    for ledger in ledgers:
        if comparison is None:
            screen.print(part_table(ledger))
        if ledger.run is not None:
            screen.print(run_table(ledger, ledger.run))
        if kernels:
            Console(width=PAPER, highlight=False).print(kernel_table(ledger))
        scene = f"{ledger.scene}: " if comparison is not None else ""
        for line in notes(ledger):
            screen.print(f"  {scene}{line}", markup=False)


def part_table(ledger: Ledger) -> Table:
    """The parts that are in, with their costs, and those that are out, with the reason."""
    table = Table(title=ledger.title)
    table.add_column("part", no_wrap=True, max_width=24)
    table.add_column("", no_wrap=True)
    table.add_column("why", overflow="fold", ratio=1)
    timed = ledger.nanoseconds is not None
    for title in ("acc.", "all", *(["ns"] if timed else []), "events"):
        table.add_column(title, justify="right", no_wrap=True)

    def numbers(part: Part) -> list[float | None]:
        time = [part.nanoseconds] if timed else []
        return [part.solving, part.total, *time, len(part.events)]

    inside = [part for part in ledger.parts if part.acts]
    sections = (
        [part for part in inside if part.role != "shared"],
        [part for part in inside if part.role == "shared"],
        [part for part in ledger.parts if not part.acts],
    )
    for section in sections:
        for part in section:
            texts = (_number(number or None) for number in numbers(part))
            reason = part.kind if part.role == "shared" else f"{part.kind}; {part.why}"
            table.add_row(part.name, "in" if part.acts else "out", reason, *texts)
        table.add_section()
    table.add_row("total", "", "", *map(_number, numbers(ledger.whole)))
    return table


def run_table(ledger: Ledger, run: RunCosts) -> Table:
    """The time that a run spent on each part that took any of it."""
    table = Table("part", title=f"{ledger.title}: the run")
    for title in ("events", "steps again", "µs", "% of the run"):
        table.add_column(title, justify="right", no_wrap=True)

    def costs(seconds: float) -> tuple[str, str]:
        share = f"{100 * seconds / run.seconds:.2f}" if run.seconds else ""
        return f"{1e6 * seconds:.1f}", share

    spent = [part for part in ledger.parts if part.run_seconds or part.run_events]
    for part in spent:
        again = _number(round(part.run_retakes or 0.0) or None)
        events = _number(part.run_events or None)
        table.add_row(part.name, events, again, *costs(part.run_seconds or 0))
    table.add_section()
    rest = run.seconds - sum(part.run_seconds or 0.0 for part in spent)
    table.add_row("all other work of the run", "", "", *costs(rest))
    table.add_row("total", str(run.events), str(run.retakes), *costs(run.seconds))
    return table


def kernel_table(ledger: Ledger) -> Table:
    """Operations of every part in every kernel."""
    table = Table("part", "kind", title=f"{ledger.title}: operations")
    for kernel in ledger.kernels:
        table.add_column(kernel, justify="right")
    for part in ledger.parts:
        if part.acts and part.role != "fidelity":
            counts = (str(part.operations.get(k, "")) for k in ledger.kernels)
            table.add_row(part.name, part.kind, *counts)
    table.add_section()
    table.add_row("total", "", *(str(ledger.totals[k]) for k in ledger.kernels))
    return table


def notes(ledger: Ledger) -> Iterator[str]:
    """Outputs, measurement and run, for which a table has no room, a line each."""
    reported = [entry.name for entry in ledger.outputs if entry.asked]
    yield f"outputs: {', '.join(reported) or 'the motion alone'}"
    silent: dict[str, list[str]] = {}
    for entry in ledger.outputs:
        if not entry.asked:
            silent.setdefault(entry.why, []).append(entry.name)
    for why, names in silent.items():
        yield f"without {', '.join(names)}: {why}"
    if ledger.loops:
        yield f"kernels: {ledger.loops}"
    if ledger.nanoseconds is not None:
        parts = ledger.parts_nanoseconds
        off = parts - ledger.nanoseconds
        percent = 100 * off / ledger.nanoseconds if ledger.nanoseconds > 0.0 else 0.0
        yield (
            f"an evaluation of accelerations, timed by itself: {ledger.nanoseconds:.1f} ns; its "
            f"parts add up to {parts:.1f} ns ({off:+.1f} ns, {percent:+.1f} %)"
        )
    if ledger.run is not None:
        took = ledger.run
        yield (
            f"a run of {took.t_end:g} s: {took.evaluations} evaluations in {took.steps} steps, "
            f"{took.rejected} more refused and {took.retakes} taken again for {took.events} "
            f"events, in {1e3 * took.seconds:.3g} ms"
        )


def comparison_table(comparison: Comparison) -> Table:
    """Two scenes side by side, and what the second has more."""
    first, second = comparison.first, comparison.second
    table = Table(title=f"{first.model}: A = {first.scene}, B = {second.scene}")
    table.add_column("part", overflow="fold")
    timed = first.nanoseconds is not None or second.nanoseconds is not None
    for title in ("in", "acc.", "all", *(["ns"] if timed else [])):
        for head in (f"{title} A", f"{title} B", *(["B-A"] if title != "in" else [])):
            table.add_column(head, justify="right", no_wrap=True)
    for row in (*comparison.rows, comparison.total):
        acts = ["-" if side is None else "in" if side else "out" for side in row.acts]
        if row is comparison.total:
            table.add_section()
            acts = ["", ""]
        times = _pair(row.nanoseconds) if timed else []
        table.add_row(row.name, *acts, *_pair(row.accelerations), *_pair(row.operations), *times)
    return table


def _pair(pair: tuple[float | None, float | None]) -> list[str]:
    """Both values and their difference; blank where both are nothing."""
    if not any(pair):
        return ["", "", ""]
    change = (pair[1] or 0) - (pair[0] or 0)
    return [*(_number(side) for side in pair), _number(change, sign="+") if change else "="]


def _number(value: float | None, sign: str = "") -> str:
    if value is None:
        return ""
    return f"{value:{sign}d}" if isinstance(value, int) else f"{value:{sign}.1f}"
