"""A table whose derivatives jump, as two smooth branches and a switching function.

A step of a run integrates a smooth function. The pieces between two jumps are therefore dealt out
by turns: the even ones to one table, the odd ones to another, each continued into its neighbours
as far as a step may reach before its end is located. The sign of a third, `knots`, says whose turn
it is: an arch of slope one at every jump, up over even pieces and down over odd ones.
"""

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import NamedTuple

from codegen.tables.piecewise_cubic import Row, Table, derivative_at

# accuracy: of the sizes of a derivative on both sides, and of the values; less is rounding
_CONTINUOUS = 1e-12


class Branches(NamedTuple):
    """Of a table with jumps."""

    even: Table
    odd: Table
    knots: Table  # positive on even pieces, negative on odd ones


Course = tuple[tuple[float, ...], tuple[Row, ...]]  # knots and rows


class _Piece(NamedTuple):
    begin: float
    end: float
    anchors: tuple[float, ...]  # the left knots of its rows
    rows: tuple[Row, ...]


def knots_function(name: str, knots: list[float], period: float) -> Table:
    """The arches of a function that repeats, whose derivatives jump at these knots of a period."""
    ends = [*knots, knots[0] + period]
    if len(knots) % 2:
        ends += [knot + period for knot in ends[1:]]
    pieces = [_Piece(a, b, (a,), ()) for a, b in pairwise(ends)]
    places, arches = _arches(pieces, periodic=True)
    return Table(name, places, arches, True, smooth=3, kind="linear", role="knots")


def knot_function(name: str) -> Table:
    """The identity, whose sign tells on which side of its one knot at 0 an argument is."""
    return Table(
        name, (0.0, 1.0), ((0.0, 1.0, 0.0, 0.0),), False, "extrapolate", 3, "linear", "knots"
    )


def range_function(table: Table) -> Table:
    """A parabola that is positive between the ends of a table, with slope one there."""
    row = (0.0, 1.0, -1.0 / table.length, 0.0)
    ends = (table.first, table.last)
    return Table(table.name, ends, (row,), False, "extrapolate", 3, table.kind, "range")


def end_pieces(table: Table) -> Table:
    """The first and the last piece of a table that is undefined beyond: what it is at its ends."""
    if len(table.rows) == 1:
        return replace(table, role="end")
    knots, rows = (table.first, *table.knots[-2:]), (table.rows[0], table.rows[-1])
    return replace(table, knots=knots, rows=rows, role="end")


def without_ends(table: Table) -> Table:
    """The same table, its first and last piece going on."""
    return replace(table, beyond="extrapolate", smooth=3)


@cache
def branches(table: Table) -> Branches | None:
    """The branches of a table; None where none of its derivatives jumps."""
    if table.smooth > 2 or table.role != "values":
        return None
    pieces = _pieces(table)
    if len(pieces) < 2:
        return None
    count = len(pieces)
    if table.periodic and count % 2:
        size = table.length
        again = [_moved(piece, size) for piece in pieces]
        pieces, count = [*pieces, *again], 2 * count
    smooth = without_ends(table)
    dealt = (_dealt(pieces, parity, table.periodic) for parity in (0, 1))
    even, odd = (replace(smooth, knots=knots, rows=rows) for knots, rows in dealt)
    places, arches = _arches(pieces, table.periodic)
    return Branches(even, odd, replace(smooth, knots=places, rows=arches, role="knots"))


def _pieces(table: Table) -> list[_Piece]:
    """The pieces between jumps, from the left; one that holds its end goes on for ever."""
    steps = list(pairwise(table.knots))
    found: list[_Piece] = []
    for (begin, end), row in zip(steps, table.rows, strict=True):
        if found and not _jumps(table, found[-1], begin, row):
            last = found.pop()
            same = row[1:] == last.rows[-1][1:] and row[2:] == (0.0, 0.0)  # one straight line
            anchors = last.anchors if same else (*last.anchors, begin)
            rows = last.rows if same else (*last.rows, row)
            found.append(_Piece(last.begin, end, anchors, rows))
        else:
            found.append(_Piece(begin, end, (begin,), (row,)))
    if (held := table.held) is not None:
        before, behind = ((value, 0.0, 0.0, 0.0) for value in held)
        (a, b), (c, d) = steps[0], steps[-1]
        found.insert(0, _Piece(a - (b - a), a, (a - (b - a),), (before,)))
        found.append(_Piece(d, d + (d - c), (d,), (behind,)))
    return found


def _jumps(table: Table, before: _Piece, knot: float, row: Row) -> bool:
    """Whether a derivative that the kind does not keep continuous jumps at a knot."""
    s, least = knot - before.anchors[-1], _CONTINUOUS * max(abs(other[0]) for other in table.rows)
    for order in range(table.smooth + 1, 4):
        left, right = derivative_at(before.rows[-1], s, order), derivative_at(row, 0.0, order)
        jump = abs(right - left)
        if jump > _CONTINUOUS * max(abs(left), abs(right)) and jump * s**order > least:
            return True
    return False


def _moved(piece: _Piece, by: float) -> _Piece:
    anchors = tuple(anchor + by for anchor in piece.anchors)
    return _Piece(piece.begin + by, piece.end + by, anchors, piece.rows)


def _dealt(pieces: list[_Piece], parity: int, periodic: bool) -> Course:
    """Knots and rows of every second piece, each begun half of the piece before it earlier.

    No earlier than its own length: far from its points a cubic is all rounding.
    """
    mine = range(parity, len(pieces), 2)
    knots: list[float] = []
    rows: list[Row] = []
    for j in mine:
        piece = pieces[j]
        first = j == 0 and not periodic
        before = pieces[j - 1]
        own = (*piece.anchors, piece.end)[1] - piece.begin
        reach = min(0.5 * (before.end - before.begin), own)
        start = piece.begin if first else piece.begin - reach
        knots += [start, *piece.anchors[1:]]
        rows += [_shifted(piece.rows[0], start - piece.anchors[0]), *piece.rows[1:]]
    period = pieces[-1].end - pieces[0].begin
    end = knots[0] + period if periodic else pieces[mine[-1]].end
    return (*knots, end), tuple(rows)


def _shifted(row: Row, by: float) -> Row:
    """The same cubic with its s from another place, in exact arithmetic rounded once."""
    if by == 0.0:
        return row
    c0, c1, c2, c3 = map(Fraction, row)
    s = Fraction(by)
    shifted = (
        c0 + s * (c1 + s * (c2 + s * c3)), c1 + s * (2 * c2 + s * 3 * c3), c2 + 3 * s * c3, c3,
    )  # fmt: skip
    a, b, c, d = map(float, shifted)
    return a, b, c, d


def _arches(pieces: list[_Piece], periodic: bool) -> Course:
    """Knots and rows of the switching function; the first and the last of an open one are lines."""
    rows: list[Row] = []
    last = len(pieces) - 1
    for j, piece in enumerate(pieces):
        h, sign = piece.end - piece.begin, 1.0 if j % 2 == 0 else -1.0
        if j == 0 and not periodic:
            rows.append((h, -1.0, 0.0, 0.0))
        elif j == last and not periodic:
            rows.append((0.0, sign, 0.0, 0.0))
        else:
            rows.append((0.0, sign, -sign / h, 0.0))
    return (*(piece.begin for piece in pieces), pieces[-1].end), tuple(rows)
