"""Tables → the functions of a generated module that look them up."""

from collections.abc import Iterator

from codegen.emit.literals import assignment
from codegen.lower.program import Lookup, Program
from codegen.tables import MARGIN, Table

POLYNOMIALS = (
    "c[k, 0] + s * (c[k, 1] + s * (c[k, 2] + s * c[k, 3]))",
    "c[k, 1] + s * (2.0 * c[k, 2] + s * (3.0 * c[k, 3]))",
    "2.0 * c[k, 2] + s * (6.0 * c[k, 3])",
    "6.0 * c[k, 3] + 0.0 * s",
)


def lookups(program: Program) -> tuple[Lookup, ...]:
    """The derivatives of tables that a program takes, in the order of their names."""
    found = {v.literal for v in program.values if isinstance(v.literal, Lookup)}
    return tuple(sorted(found, key=lambda look: (look.table.name, look.order)))


def function_name(look: Lookup) -> str:
    """``table_lift``, and ``table_lift_d1`` for its first derivative."""
    return f"table_{look.table.name}" + (f"_d{look.order}" if look.order else "")


def spline_lines(program: Program) -> Iterator[str]:
    """Tables and functions, nothing where a program takes none."""
    wanted = lookups(program)
    for table in dict.fromkeys(look.table for look in wanted):
        yield from ("", "")
        yield from _table(table)
        for look in wanted:
            if look.table == table:
                yield from ("", "")
                yield from _function(look)


def _table(table: Table) -> Iterator[str]:
    upper, name = table.name.upper(), f"table_{table.name}"
    first, length = table.knots[0], table.knots[-1] - table.knots[0]
    yield from assignment(f"{upper}_KNOTS", table.knots)
    yield from assignment(f"{upper}_ROWS", table.rows)
    yield f"{upper}_X, {upper}_C = np.array({upper}_KNOTS), np.array({upper}_ROWS)"
    yield from ("", "")
    yield '@numba.njit("Tuple((i8, f8))(f8)", **OPTIONS)'
    yield f"def {name}_at(x):"
    kind = "periodic" if table.periodic else "nan beyond its ends"
    yield f'    """Interval of the table and the distance from its left knot; {kind}."""'
    if table.periodic:
        yield f"    x -= {length!r} * math.floor((x - {first!r}) / {length!r})"
    else:
        low, high = first - MARGIN * length, first + (1 + MARGIN) * length
        yield f"    if not {low!r} <= x <= {high!r}:"
        yield "        return 0, math.nan"
    yield f"    low, high = 0, {len(table.rows)}"
    yield "    while high - low > 1:"
    yield "        middle = (low + high) // 2"
    yield f"        if x < {upper}_X[middle]:"
    yield "            high = middle"
    yield "        else:"
    yield "            low = middle"
    yield f"    return low, x - {upper}_X[low]"


def _function(look: Lookup) -> Iterator[str]:
    yield '@numba.njit("f8(f8)", **OPTIONS)'
    yield f"def {function_name(look)}(x):"
    what = f"Derivative {look.order} of the" if look.order else "The"
    yield f'    """{what} cubic spline {look.table.name}."""'
    yield f"    k, s = table_{look.table.name}_at(x)"
    yield f"    c = {look.table.name.upper()}_C"
    yield f"    return {POLYNOMIALS[look.order]}"
