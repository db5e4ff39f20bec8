"""How objects show themselves: a line for a terminal, small tables for a notebook."""

from collections.abc import Iterable, Sequence
from html import escape

LISTED = 8  # layout: names that a line lists
ROUNDING = 1e-13  # layout: of the largest of several numbers; less is shown as 0


def without_rounding(values: Iterable[float]) -> list[float]:
    """Numbers of one kind as they are shown: what is rounding beside the largest of them is 0."""
    every = [float(value) for value in values]
    least = ROUNDING * max((abs(x) for x in every if x == x), default=0.0)  # noqa: PLR0124
    return [0.0 if abs(x) < least or x == 0.0 else x for x in every]


def with_unit(value: float, unit: str) -> str:
    """A number in six digits and its unit, but for "1"."""
    return f"{value:.6g} {unit}".removesuffix(" 1")


def listed(names: Iterable[str], empty: str = "none", most: int = LISTED) -> str:
    """Names in a line, the first ones of many."""
    every = list(names)
    rest = len(every) - most
    return (", ".join(every[:most]) or empty) + (f" and {rest} more" if rest > 0 else "")


def html_of(text: str, *tables: str) -> str:
    """Lines of text, the first one bold, and tables below them."""
    first, *rest = (escape(line) for line in text.splitlines() or [""])
    lines = "<br>".join([f"<b>{first}</b>", *rest])
    return f"<div><p>{lines}</p>{''.join(tables)}</div>"


def html_table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in which numbers are shown in six digits, to the right."""

    def cell(value: object) -> str:
        if isinstance(value, float):
            return f"<td style='text-align:right'>{value:.6g}</td>"
        return f"<td>{escape(str(value))}</td>"

    body = "".join(f"<tr>{''.join(map(cell, row))}</tr>" for row in rows)
    titles = "".join(f"<th style='text-align:left'>{escape(title)}</th>" for title in head)
    return f"<table><thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table>" if body else ""


def counted(number: int, noun: str) -> str:
    """The number with its noun, "1 body" or "3 bodies", "2 degrees of freedom"."""
    head, of, rest = noun.partition(" of ")
    plural = f"{head[:-1]}ies" if head.endswith("y") else f"{head}s"
    return f"{number} {head if number == 1 else plural}{of}{rest}"
