"""Ledgers on a terminal: a part a row, no wider than a person reads."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain

from rich.console import Console
from rich.table import Table

from codegen import presentation
from codegen.explain.ledger import Difference, Ledger, Part, RunCosts

PAPER = 1000  # columns of a table that is as wide as its content, whatever the terminal


def show(ledgers: Sequence[Ledger], differences: Sequence[Difference], *, kernels: bool) -> None:
    """Print the ledgers, or the differences of two; with `kernels` also the wide tables."""
    if differences:
        presentation.show([comparison_table(ledgers[0], ledgers[1], differences)], ())
    for ledger in ledgers:
        tables = [] if differences else [part_table(ledger)]
        tables += [] if ledger.run is None else [run_table(ledger, ledger.run)]
        presentation.show(tables, ())
        if kernels:
            Console(width=PAPER, highlight=False).print(kernel_table(ledger))
        scene = f"{ledger.scene}: " if differences else ""
        presentation.show((), (f"{scene}{line}" for line in notes(ledger)))


Row = tuple[str | float | None, ...]


def _table(
    title: str, texts: Sequence[str], numbers: Sequence[str], *parts: Iterable[Row]
) -> Table:
    """A table of columns of texts, then of numbers, its rows in sections."""
    sections = ((map(_cell, row) for row in rows) for rows in parts)
    return presentation.new_table(title, (*texts, *numbers), *sections, texts=len(texts))


def _cell(value: str | float | None) -> str:
    """A text, a whole number or one with a decimal; None is blank."""
    if value is None:
        return ""
    return f"{value:.1f}" if isinstance(value, float) else str(value)


def part_table(ledger: Ledger) -> Table:
    """The parts that are in, with their costs, and those that are out, with the reason."""
    timed = ledger.nanoseconds is not None

    def row(part: Part) -> Row:
        word = "in" if part.acts else "out"
        why = part.kind if part.role == "shared" else f"{part.kind}; {part.why}"
        first = ("total", "", "") if part.role == "" else (part.name, word, why)
        time = [part.nanoseconds] if timed else []
        numbers = [part.solving, part.total, *time, len(part.events)]
        return (*first, *(n or (None if part.role else n) for n in numbers))

    inside = [part for part in ledger.parts if part.acts]
    return _table(
        ledger.title, ("part", "", "why"), ("acc.", "all", *["ns"] * timed, "events"),
        (row(part) for part in inside if part.role != "shared"),
        (row(part) for part in inside if part.role == "shared"),
        (row(part) for part in ledger.parts if not part.acts), [row(ledger.whole)],
    )  # fmt: skip


def run_table(ledger: Ledger, run: RunCosts) -> Table:
    """The time that a run spent on each part that took any of it."""

    def costs(seconds: float) -> tuple[str, str]:
        share = f"{100 * seconds / run.seconds:.2f}" if run.seconds else ""
        return f"{1e6 * seconds:.1f}", share

    spent = [part for part in ledger.parts if part.run_seconds or part.run_events]
    rest = run.seconds - sum(part.run_seconds or 0.0 for part in spent)
    return _table(
        f"{ledger.title}: the run", ("part",), ("events", "steps again", "µs", "% of the run"),
        (
            (p.name, p.run_events or None, round(p.run_retakes or 0.0) or None,
             *costs(p.run_seconds or 0))
            for p in spent
        ),
        [
            ("all other work of the run", "", "", *costs(rest)),
            ("total", str(run.events), str(run.retakes), *costs(run.seconds)),
        ],
    )  # fmt: skip


def kernel_table(ledger: Ledger) -> Table:
    """Operations of every part in every kernel."""
    inside = (part for part in ledger.parts if part.acts and part.role != "fidelity")
    return _table(
        f"{ledger.title}: operations", ("part", "kind"), ledger.kernels,
        ((p.name, p.kind, *(p.operations.get(k) for k in ledger.kernels)) for p in inside),
        [("total", "", *(ledger.totals[kernel] for kernel in ledger.kernels))],
    )  # fmt: skip


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


def comparison_table(first: Ledger, second: Ledger, rows: Sequence[Difference]) -> Table:
    """Two scenes side by side, and what the second has more."""
    timed = first.nanoseconds is not None or second.nanoseconds is not None
    counts = ["acc.", "all", *["ns"] * timed]
    words = {None: "-", True: "in", False: "out"}

    def cells(row: Difference) -> Row:
        acts = ["", ""] if row is rows[-1] else [words[side] for side in row.acts]
        pairs = [row.accelerations, row.operations, *[row.nanoseconds] * timed]
        return (row.name, *acts, *chain.from_iterable(map(_pair, pairs)))

    return _table(
        f"{first.model}: A = {first.scene}, B = {second.scene}",
        ("part",), ("in A", "in B", *(h for n in counts for h in (f"{n} A", f"{n} B", "B-A"))),
        map(cells, rows[:-1]), [cells(rows[-1])],
    )  # fmt: skip


def _pair(pair: tuple[float | None, float | None]) -> list[str]:
    """Both values and their difference; blank where both are nothing."""
    if not any(pair):
        return ["", "", ""]
    change = (pair[1] or 0) - (pair[0] or 0)
    sign = "+" if change > 0 else ""
    return [*map(_cell, pair), f"{sign}{_cell(change)}" if change else "="]
