"""How a result shows itself, in a terminal and in a notebook."""

from typing import TYPE_CHECKING

import numpy as np

from codegen.object_display import counted, html_of, html_table, listed, without_rounding

if TYPE_CHECKING:
    from runtime.results.result import Result


def text_of(result: "Result") -> str:
    """The headline, and what there is to look up."""
    rows, states = result.description.positions, result.description.states
    lines = [result.headline, f"  coordinates  {listed(f'{r.name} ({r.unit})' for r in rows)}"]
    if states:
        units = (f"{row.name} ({row.unit or '1'})" for row in states)
        lines.append(f"  states       {listed(units)}")
    points = result.description.tracked
    acting = [name for name in result.description.effects.names if name not in points]
    reactions = (row for row in result.description.reactions if row.component)
    exerted = (row.element for row in reactions if "N" in row.unit)
    if joints := [name for name in dict.fromkeys(exerted) if name not in acting]:
        lines.append(f"  reactions    {listed(joints)} (N, N m)")
    if acting:
        lines.append(f"  effects      {listed(acting)}")
    if points:
        lines.append(f"  points       {listed(points)} (m)")
    if outputs := result.description.series.of_kind("expression"):
        lines.append(f"  outputs      {listed(f'{row.name} ({row.unit})' for row in outputs)}")
    if result.events:
        lines.append(f"  events       {len(result.events)}, in .events")
    if changes := result.reconnections:
        lines.append(f"  joints       {counted(len(changes), 'change')}, in .reconnections")
    return "\n".join(lines)


def html_of_result(result: "Result") -> str:
    """The same with a table of the coordinates, for notebooks."""
    if not len(result.t):
        return html_of(repr(result))
    rows = [(row.name, row.unit) for row in result.description.positions]
    rows += [(row.name, row.unit or "1") for row in result.description.states]
    x = np.array([result.series(name)[0] for name, _ in rows]).T
    numbers = zip(*map(without_rounding, (x[0], x[-1], x.min(axis=0), x.max(axis=0))), strict=True)
    table = html_table(
        ("coordinate", "unit", "first", "last", "least", "greatest"),
        ((*row, *of) for row, of in zip(rows, numbers, strict=True)),
    )
    text = [line for line in repr(result).splitlines() if not line.startswith("  coordinates ")]
    return html_of("\n".join(text), table)
