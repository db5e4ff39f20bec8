"""A result as one self-contained HTML page: the machine in motion, its curves, and tables."""

from collections.abc import Iterator
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from codegen.presentation import html_page
from runtime.show.animation.animation import Animation

if TYPE_CHECKING:
    from runtime.results.result import Result

_MOST_QUANTITIES = 10  # layout: quantities of an accuracy target in a table
_MOST_ROWS = 200  # layout: events, or changes of joints, in a table


def page(result: "Result") -> str:
    """The page as text: the player on top, then tables; of a run without instants tables alone."""
    tables = "\n".join(["<article class=report>", *_tables(result), "</article>"])
    if not len(result.t):
        return html_page(result.description.title, [tables])
    return Animation([result], below=tables).html


def _tables(result: "Result") -> Iterator[str]:
    generator = escape(result.description.generator.split()[-1])
    state = "outcome failed" if result.failed else "outcome"
    stats = ((name.replace("_", " "), value) for name, value in result.stats.items())
    yield f"<h1>{escape(result.description.title)}</h1>"
    yield f"<p>{escape(result.analysis)}, linkwright {generator}</p>"
    yield f'<p class="{state}"><b>{result.outcome.name}</b>: {escape(result.message)}</p>'
    yield _section("Machine", _machine(result))
    yield _section("Parameters", _parameters(result))
    yield _section("Checks", _checks(result))
    yield from _accuracy(result)
    yield f"<details><summary>Counters of the solver</summary>{_table(stats)}</details>"
    yield _section("At the end", _last(result))
    if result.events:
        rows = ((f"{e.time:.9g} s", e.text) for e in result.events[:_MOST_ROWS])
        yield _section("Events", rows)
    if result.reconnections:
        changes = ((f"{one.time:.9g} s", str(one)) for one in result.reconnections[:_MOST_ROWS])
        yield _section("Joints that came or went", changes)


def _section(title: str, rows: Iterator[tuple[str, object]]) -> str:
    return f"<h2>{title}</h2>\n{_table(rows)}"


def _table(rows: Iterator[tuple[str, object]]) -> str:
    lines = []
    for name, value in rows:
        number = isinstance(value, int | float | np.number)
        text = f"{value:.9g}" if number else str(value)
        kind = ' class="number"' if number else ""
        lines.append(f"<tr><td>{escape(name)}</td><td{kind}>{escape(text)}</td></tr>")
    return f"<table>{''.join(lines)}</table>" if lines else "<p>none</p>"


def _machine(result: "Result") -> Iterator[tuple[str, object]]:
    description = result.description
    yield "bodies", ", ".join(description.bodies)
    yield "coordinates", len(description.positions)
    if description.states:
        yield "states", ", ".join(description.states.names)
    yield "constraints", len(description.constraints)
    elements = dict.fromkeys(row.element for row in description.constraints)
    yield "joints and drivers", ", ".join(elements)
    states = description.states.names
    yield "effects", ", ".join(n for n in description.effects.names if n not in states) or "none"


def _parameters(result: "Result") -> Iterator[tuple[str, object]]:
    units = {row.name: row.unit for row in result.description.parameters}
    for name, value in result.parameters.items():
        yield f"{name}, {units[name]}" if units[name] else name, value


def _checks(result: "Result") -> Iterator[tuple[str, object]]:
    residual = result.samples.residual
    if len(residual):
        yield "largest |Φ|, m or rad", float(np.nanmax(residual[:, 0]))
        yield "largest |Φ_q q̇ - ν|, m/s or rad/s", float(np.nanmax(residual[:, 1]))
    if result.description.has_masses and len(result.t):
        energy = result.energy()
        yield "energy at the start, J", float(energy[0])
        yield "energy at the end, J", float(energy[-1])


def _accuracy(result: "Result") -> Iterator[str]:
    """The accuracy target, the accuracy reached, and the runs."""
    accuracy = result.accuracy
    if accuracy is None:
        return
    yield "<h2>Accuracy</h2>"
    yield f"<p>{escape(' '.join(accuracy.sentences()))}</p>"
    yield _table((row.name, row.error) for row in accuracy.quantities[:_MOST_QUANTITIES])
    yield _table(
        (f"{run.method}, {run.formulation}, rtol = {run.rtol:.1e}", f"{run.seconds * 1e3:.3g} ms")
        for run in accuracy.runs
    )


def _last(result: "Result") -> Iterator[tuple[str, object]]:
    if len(result.t):
        for row in result.description.positions:
            yield f"{row.name}, {row.unit}", float(result.q(row.name)[-1])
        for state in result.description.states:
            yield f"{state.name}, {state.unit or '1'}", float(result.y(state.name)[-1])
