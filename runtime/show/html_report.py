"""A result as one self-contained HTML page: machine, parameters, checks, statistics, pictures."""

from collections.abc import Iterator
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from codegen.figures_and_html import finish_axes, html_figure, html_page, new_figure
from runtime.results.effect_series import quantity_of
from runtime.results.motion_at_instants import for_curves

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from runtime.results.result import Result

MOST_LINES = 10
_MOST_ROWS = 200  # layout: events, or changes of joints, in a table


def page(result: "Result") -> str:
    """The page as text."""
    description = result.description
    generator = escape(description.generator.split()[-1])
    state = "outcome failed" if result.failed else "outcome"
    stats = ((name.replace("_", " "), value) for name, value in result.stats.items())
    parts = [
        f"<h1>{escape(description.title)}</h1>",
        f"<p>{escape(result.analysis)}, linkwright {generator}</p>",
        f'<p class="{state}"><b>{result.outcome.name}</b>: {escape(result.message)}</p>',
        _section("Machine", _machine(result)),
        _section("Parameters", _parameters(result)),
        _section("Checks", _checks(result)),
        *_accuracy(result),
        _section("Statistics", stats),
        _section("At the end", _last(result)),
        "<h2>Over time</h2>",
        *map(html_figure, _figures(result)),
    ]
    if result.events:
        rows = ((f"{e.time:.9g} s", e.text) for e in result.events[:_MOST_ROWS])
        parts.append(_section("Events", rows))
    if result.reconnections:
        changes = ((f"{one.time:.9g} s", str(one)) for one in result.reconnections[:_MOST_ROWS])
        parts.append(_section("Joints that came or went", changes))
    return html_page(description.title, parts)


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
    yield _table((row.name, row.error) for row in accuracy.quantities[:MOST_LINES])
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


def _figures(result: "Result") -> Iterator["Figure"]:
    """Coordinates and velocities by unit, then reactions by unit, a picture each."""
    result = for_curves(result)
    description = result.description
    if len(result.t) < 2:
        return
    groups: dict[str, list[str]] = {}
    for row in description.positions:
        groups.setdefault(f"position, {row.unit}", []).append(row.name)
        groups.setdefault(f"velocity, {row.velocity_unit}", []).append(row.velocity)
    for state in description.states:
        groups.setdefault(f"state, {state.unit or '1'}", []).append(state.name)
    for reaction in description.reactions:
        kind = "driver" if reaction.element in description.drivers else "reaction"
        if reaction.element in description.effects.names:
            point = reaction.element in description.tracked
            kind = "point" if point else quantity_of(reaction) or "effect"
        groups.setdefault(f"{kind}, {reaction.unit}", []).append(reaction.name)
    for title, names in groups.items():
        moving = [name for name in names if np.ptp(result.series(name)[0]) > 0.0]
        for first in range(0, len(moving), MOST_LINES):
            yield _figure(result, title, moving[first : first + MOST_LINES])


def _figure(result: "Result", title: str, names: list[str]) -> "Figure":
    figure = new_figure("report", 9, 3)
    axes = figure.subplots()
    for name in names:
        axes.plot(result.t, result.series(name)[0], label=name, linewidth=1.2)
    axes.set(xlabel="t, s", ylabel=title.partition(", ")[2])
    axes.set_title(title, loc="left")
    finish_axes(axes, alpha=0.3)
    axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure
