"""The functions of a generated module beside its kernels: sine and cosine, and lookups of tables.

Nearly every angle of a mechanism is needed with both. The library's functions reduce the angle
twice, and to more digits than it has. Here the argument is reduced once, to ±π/4, with π/2 in three
parts (W. J. Cody and W. Waite, Software Manual for the Elementary Functions, 1980); sine and cosine
are then the polynomials of fdlibm, without a branch: accurate to two units of the last digit, in
7 ns instead of 9 to 12. Adding 1.5 2⁵² leaves a number without room for a fraction, which rounds
it.
"""

from collections.abc import Iterator

from codegen.emit.line_wrapping import assignment, literal, prose
from codegen.lower.program import Lookup, Program
from codegen.tables.piecewise_cubic import MARGIN, Table

SIN_COS = "sin_cos"

SIN_COS_FUNCTION = f'''
@numba.njit(**OPTIONS)
def {SIN_COS}(x):
    """sin x and cos x: x = n π/2 + r with r in ±π/4, then polynomials in r."""
    if not abs(x) < 1e6:
        return math.sin(x), math.cos(x)
    n = (x * 0.6366197723675814 + 6755399441055744.0) - 6755399441055744.0
    r = x - n * 1.5707963267341256 - n * 6.077100506303966e-11 - n * 2.0222662487959506e-21
    k = int(n)
    z = r * r
    w = z * z
    s = (
        -0.16666666666666632
        + z * 0.00833333333332249
        + w
        * (
            -0.0001984126982985795
            + z * 2.7557313707070068e-06
            + w * (-2.5050760253406863e-08 + z * 1.58969099521155e-10)
        )
    )
    c = (
        0.0416666666666666
        + z * -0.001388888888887411
        + w
        * (
            2.480158728947673e-05
            + z * -2.7557314351390663e-07
            + w * (2.087572321298175e-09 + z * -1.1359647557788195e-11)
        )
    )
    s = r + r * z * s
    c = 1.0 - 0.5 * z + w * c
    sine = c if k & 1 else s
    cosine = s if k & 1 else c
    return -sine if k & 2 else sine, -cosine if (k + 1) & 2 else cosine
'''


BEYOND = {
    "stop": "nan beyond its ends",
    "hold": "constant beyond its ends",
    "extrapolate": "the end pieces go on",
}
POLYNOMIALS = (
    "c[k, 0] + s * (c[k, 1] + s * (c[k, 2] + s * c[k, 3]))",
    "c[k, 1] + s * (2.0 * c[k, 2] + s * (3.0 * c[k, 3]))",
    "2.0 * c[k, 2] + s * (6.0 * c[k, 3])",
    "6.0 * c[k, 3] + 0.0 * s",
)


def lookups(program: Program) -> dict[Lookup, str]:
    """The derivatives of tables that a program takes → names of the functions that look them up.

    Tables are numbered in the order of their names: what a modeller calls them may be the name of
    something else in the module.
    """
    numbers: dict[Table, int] = {}
    names = {}
    for look in sorted(program.lookups, key=lambda x: (x.table.name, x.table.digest, x.order)):
        number = numbers.setdefault(look.table, len(numbers))
        names[look] = f"table_{number}" + (f"_d{look.order}" if look.order else "")
    return names


def spline_lines(program: Program) -> Iterator[str]:
    """Tables and functions, nothing where a program takes none."""
    names = lookups(program)
    for number, table in enumerate(dict.fromkeys(look.table for look in names)):
        yield from _table(table, f"table_{number}")
        for look, name in names.items():
            if look.table == table:
                yield from _function(look, name, f"table_{number}")


def _table(table: Table, name: str) -> Iterator[str]:
    upper = name.upper()
    first, last, length, held = table.first, table.last, table.length, table.held
    yield from ("", "", f"# {prose(table.name)}")
    yield from assignment(f"{upper}_KNOTS", table.knots)
    ends = [(value, 0.0, 0.0, 0.0) for value in held] if held else []
    yield from assignment(f"{upper}_ROWS", (*table.rows, *ends))
    yield f"{upper}_X, {upper}_C = np.array({upper}_KNOTS), np.array({upper}_ROWS)"
    yield from ("", "", '@numba.njit("Tuple((i8, f8))(f8)", **OPTIONS)')
    yield f"def {name}_at(x):"
    kind = "periodic" if table.periodic else BEYOND[table.beyond]
    yield f'    """Interval of the table and the distance from its left knot; {kind}."""'
    if table.periodic:
        begin, size = literal(first), literal(length)
        yield f"    x -= {size} * math.floor((x - {begin}) / {size})"
    elif held:
        count = len(table.rows)
        yield f"    if not {literal(first)} <= x <= {literal(last)}:"
        yield f"        return ({count} if x < {literal(first)} else {count + 1}), 0.0 * x"
    elif table.stops:
        low, high = first - MARGIN * length, first + (1 + MARGIN) * length
        yield f"    if not {literal(low)} <= x <= {literal(high)}:"
        yield "        return 0, math.nan"
    yield f"    low, high = 0, {len(table.rows)}"
    yield "    while high - low > 1:"
    yield "        middle = (low + high) // 2"
    yield f"        if x < {upper}_X[middle]:"
    yield "            high = middle"
    yield "        else:"
    yield "            low = middle"
    yield f"    return low, x - {upper}_X[low]"


def _function(look: Lookup, name: str, table: str) -> Iterator[str]:
    yield from ("", "", '@numba.njit("f8(f8)", **OPTIONS)')
    yield f"def {name}(x):"
    what = f"Derivative {look.order} of the" if look.order else "The"
    yield f'    """{what} {_noun(look.table)} {prose(look.table.name)}."""'
    yield f"    k, s = {table}_at(x)"
    yield f"    c = {table.upper()}_C"
    yield f"    return {POLYNOMIALS[look.order]}"


def _noun(table: Table) -> str:
    """What a table is, in a docstring."""
    switching = {"knots": "function that changes its sign at knots of", "range": "range of"}
    kinds = {"spline": "cubic spline", "linear": "polygon"}
    return switching.get(table.role) or kinds.get(table.kind, f"{table.kind} curve")
