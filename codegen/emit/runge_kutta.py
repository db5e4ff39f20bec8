"""A Butcher tableau → the text of the module that steps, estimates and interpolates with it.

Every linear combination of stages is one unrolled sum, without the zeros of the tableau, inside one
loop over the 2 n entries of the state.
"""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import zip_longest

from codegen.emit.line_wrapping import items, literal, wrap_pieces
from codegen.tableaus.tableau import Stage, Tableau, Weights

COMMAND = "python -m codegen methods"
LOOP = "    for j in range(length):"
HERMITE = 4  # rows of the dense output that follow from states and derivatives at both ends

# The functions of a method: the types that the runtime compiles them for, and their arguments.
FUNCTIONS = {
    "stages": ("STAGES", "context: Integers, t: float, h: float", "int"),
    "error": ("ERROR", "context: Integers, h: float, rtol: float", "float"),
    "dense": ("DENSE", "context: Integers, t: float, h: float", "int"),
    "propose": ("PROPOSE", "context: Integers, h: float", "float"),
}
ROWS = {"y0": "Y0", "y1": "Y1", "z": "STAGE", "atol": "ATOL"}
"""Rows of the workspace by the names that the text gives them."""

IMPORTS = """
import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core import workspace_rows as ws
from runtime.core.arrays import Integers
from runtime.core.dense_output import hermite_rows
from runtime.core.jit import addressed
from runtime.core.state_derivative import evaluate_rhs
from runtime.integrate import stability_limit
from runtime.integrate.method import Method
"""


def module_text(name: str, tableau: Tableau) -> str:
    """The whole module of a method."""
    lines = [
        f"# Generated from codegen/tableaus/{name}.py.",
        f"# Do not edit: change the tableau, then run {COMMAND}",
        f'"""{tableau.about.strip() if tableau.about else ""}',
        '"""',
        *IMPORTS.rstrip().split("\n"),
        *_step_control(tableau),
        *_stages(tableau),
        *_error(tableau),
        *_dense(tableau),
        *(_propose(tableau) if tableau.stability_edge is not None else ()),
        *_record(tableau),
    ]
    return "\n".join(lines) + "\n"


def _step_control(tableau: Tableau) -> Iterator[str]:
    """The names that step control takes."""
    if tableau.stability_edge is None:
        yield "from runtime.integrate.step_control import propose"
        return
    powers = ", ".join(literal(float(x)) for x in reversed(tableau.stability_function))
    yield from ("", f"EDGE = {literal(tableau.stability_edge)}  # accuracy: as the tableau says")
    yield from wrap_pieces("POWERS = np.array([", items(powers), "])")


def _stages(tableau: Tableau) -> Iterator[str]:
    yield from _head("stages", "Take the step from Y0 with derivative K to Y1, not yet corrected.")
    yield from _views(("y0", "y1", "z"), range(1, tableau.last + 1))
    yield "    taken = 0"
    for number, stage in enumerate(tableau.stages, 2):
        yield from _stage(number, stage)
    yield LOOP
    yield from wrap_pieces("        y1[j] = y0[j] + h * (", _terms(tableau.b), ")")
    yield "    return taken"


def _stage(number: int, stage: Stage) -> Iterator[str]:
    """State and derivative of a stage."""
    yield LOOP
    yield from wrap_pieces("        z[j] = y0[j] + h * (", _terms(stage.a), ")")
    instant = "t + h" if stage.c == 1 else f"t + {literal(float(stage.c))} * h"
    yield f"    taken += evaluate_rhs(context, {instant}, ws.STAGE, {_row(number)})"


def _error(tableau: Tableau) -> Iterator[str]:
    summary = "Estimated error of the step over its tolerance, root mean square over q and v."
    yield from _head("error", summary)
    yield from _views(("y0", "y1", "atol"), _used(tableau.error, tableau.lower))
    scale = "atol[j] + rtol * max(abs(y0[j]), abs(y1[j]))"
    if not tableau.lower:
        yield from ("    total = 0.0", LOOP)
        yield from wrap_pieces("        estimate = h * (", _terms(tableau.error), ")")
        yield from (f"        ratio = estimate / ({scale})", "        total += ratio * ratio")
        if tableau.stability_edge is not None:
            yield "    if stability_limit.permits_growth(rtol, length, EDGE):"
            yield f"        stability_limit.observe(context, {_row(tableau.last + 1)})"
        yield "    return float(np.sqrt(total / length))"
        return
    pairs = zip_longest(tableau.b, tableau.lower, fillvalue=Fraction())
    second = tuple(b - x for b, x in pairs)
    yield from ("    high, low = 0.0, 0.0", LOOP, f"        inverse = 1.0 / ({scale})")
    for name, weights in (("high", tableau.error), ("low", second)):
        yield from wrap_pieces("        ratio = inverse * (", _terms(weights), ")")
        yield f"        {name} += ratio * ratio"
    yield "    both = high + 0.01 * low"
    yield "    if both == 0.0:  # also where a ratio is too small to be squared"
    yield "        return 0.0"
    yield "    return float(h * high / np.sqrt(both * length))"


def _dense(tableau: Tableau) -> Iterator[str]:
    summary = "Fill the coefficient rows of the dense output of the step from Y0 to Y1."
    yield from _head("dense", summary)
    used = _used(*(stage.a for stage in tableau.further), *tableau.dense)
    if tableau.further:
        yield from (*_views(("y0", "z"), used), "    taken = 0")
    elif tableau.dense:
        yield from _views((), used)
    for number, stage in enumerate(tableau.further, tableau.last + 2):
        yield from _stage(number, stage)
    yield f"    hermite_rows(context, h, {_row(tableau.last + 1)})"
    rows = range(HERMITE, HERMITE + len(tableau.dense))
    yield from (f"    f{k} = ws.row_of(context, ws.F + {k})" for k in rows)
    yield from [LOOP] if rows else []
    for k, weights in zip(rows, tableau.dense, strict=True):
        yield from wrap_pieces(f"        f{k}[j] = h * (", _terms(weights), ")")
    yield "    return taken" if tableau.further else "    return 0"


def _propose(tableau: Tableau) -> Iterator[str]:
    yield from _head("propose", "Ratio of the next step's length to this accepted one's.")
    yield "    return float(stability_limit.stable_ratio(context, h, POWERS, EDGE))"


def _record(tableau: Tableau) -> Iterator[str]:
    nodes = ", ".join(literal(float(stage.c)) for stage in tableau.all_stages)
    yield from ("", "", "METHOD = Method(")
    yield f"    estimate_order={tableau.error_order + 1},"
    yield f"    stage_calls={len(tableau.stages)},"
    yield f"    last={tableau.last},"
    yield f"    dense_rows={HERMITE + len(tableau.dense)},"
    yield f"    dense_calls={len(tableau.further)},"
    yield from wrap_pieces("    nodes=(", items(nodes), "),")
    for name in ("beta", "safety", "shrink", "grow"):
        yield f"    {name}={literal(getattr(tableau, name))},"
    for name in FUNCTIONS:
        yield f"    {name}={name},"
    yield "    accepted=stability_limit.idle,"
    if tableau.stability_edge is None:
        yield from ("    restart=stability_limit.idle,", ")")
    else:
        hooks = ("restart", "memory")
        yield from (*(f"    {name}=stability_limit.{name}," for name in hooks), ")")


# -- lines -----------------------------------------------------------------------------------


def _head(name: str, summary: str) -> Iterator[str]:
    kind, arguments, result = FUNCTIONS[name]
    yield from ("", "", f"@addressed(ft.{kind})")
    yield from wrap_pieces(f"def {name}(", items(arguments), f") -> {result}:")
    yield f'    """{summary}"""'


def _views(rows: Sequence[str], stages: Sequence[int]) -> Iterator[str]:
    yield "    length = 2 * context[ft.COORDINATES]"
    for name in rows:
        yield f"    {name} = ws.row_of(context, ws.{ROWS[name]})"
    for number in stages:
        yield f"    k{number} = ws.row_of(context, {_row(number)})"


def _row(number: int) -> str:
    """The workspace's row of a stage's derivative."""
    return "ws.K" if number == 1 else f"ws.K + {number - 1}"


def _used(*rows: Weights) -> list[int]:
    """Stages that have a weight in any of the rows."""
    return sorted({number for row in rows for number, x in enumerate(row, 1) if x})


def _terms(row: Weights) -> list[str]:
    """The products of a linear combination of stages, each with its sign in front."""
    weights = [(number, float(x)) for number, x in enumerate(row, 1) if x]
    terms = [f"{'-' if x < 0 else '+'} {literal(abs(x))} * k{number}[j]" for number, x in weights]
    if terms:
        terms[0] = terms[0].removeprefix("+ ").replace("- ", "-", 1)
    return terms
