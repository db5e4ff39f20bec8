"""A lowered scene → the text of its generated module, and of the modules that go with it.

These have derivatives, reduced equations, the picture. Each carries the SHA-256 of the text of the
scene's own module: with another one it is stale.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from codegen.drawing.picture import SPACE_VERSION, VERSION
from codegen.emit.kernel import Arguments, KernelText, folded_numbers, formula
from codegen.emit.line_wrapping import assignment, checked, literal, prose
from codegen.emit.module_functions import SIN_COS_FUNCTION, lookups, spline_lines
from codegen.emit.rolled_kernel import RolledKernelText
from codegen.files.generated_modules import MARK, UNSIGNED, signed
from codegen.lower.kernels.picture_kernels import LoweredPicture
from codegen.lower.lowered_scene import Lowered
from codegen.lower.module_tables import Pattern
from codegen.lower.operation_count import operations
from codegen.lower.program import LEAVES, Kernel, Lookup, Program
from codegen.object_display import counted
from codegen.reduce.reduced_kernels import Reduced
from codegen.reroll.batching import Batching
from codegen.reroll.rerolling import Rerolling

Unroll = Literal["auto", "always", "never"]
"""Write kernels out where that is short; always; never: in loops, however few operations."""

LONGEST = 6000  # measured: statements of the longest module that is written out without loops
SHORTEST = 100  # measured: statements up to which a kernel is written out in any module
GAIN = 0.6  # measured: largest ratio of a kernel's statements with loops to those without
LONGEST_KERNEL = 12_000  # measured: statements beyond which a kernel is computed in batches

KernelTexts = list[KernelText | RolledKernelText]


def kernel_texts(program: Program, arguments: Arguments, unroll: Unroll) -> KernelTexts:
    """The texts of a program's kernels, each written out or in loops.

    Straight code is up to twice as fast where a machine is small; from some forty bodies on it is
    no faster than loops, while its compilation takes minutes. So a long module has loops in all of
    its kernels that repeat themselves.
    """
    sizes = [statements(program, kernel) for kernel in program.kernels]
    is_long = sum(sizes) > LONGEST
    return [
        _text_in_loops(program, kernel, arguments, size if unroll == "auto" else None)
        if "p" in kernel.arguments
        and (unroll == "never" or (unroll == "auto" and is_long and size > SHORTEST))
        else KernelText(program, kernel, arguments)
        for kernel, size in zip(program.kernels, sizes, strict=True)
    ]


def _text_in_loops(
    program: Program, kernel: Kernel, arguments: Arguments, size: int | None
) -> KernelText | RolledKernelText:
    """The text of a kernel in loops, in batches, or written out where that is as short."""
    slots = arguments.slots(program)
    constants = {k: slots[k] for k in program.hoisted(kernel)}
    rolled = Rerolling(program, kernel, constants).rolled()
    if rolled.statements > LONGEST_KERNEL:
        rolled = Batching(program, kernel, constants).rolled()
    if size is not None and rolled.statements > GAIN * size:
        return KernelText(program, kernel, arguments)
    return RolledKernelText(program, kernel, rolled, arguments)


def statements(program: Program, kernel: Kernel) -> int:
    """Operations and outputs of a kernel, negations and choices among them."""
    counts = program.counts(kernel).items()
    return sum(count for op, count in counts if op not in LEAVES) + len(kernel.outputs)


OPTIONS = '{"cache": True, "error_model": "numpy", "fastmath": {"contract"}'
BARE = ', "_nrt": False}'
"""Of numba. Where no kernel has a workspace, none makes arrays: without counts of references they
compile a sixth faster. They keep the entry from C, by which numba passes them as values of a
`FunctionType`.
"""


@dataclass(frozen=True)
class Origin:
    """Where a module comes from."""

    generator: str  # name and version
    sources: tuple[tuple[str, str], ...]  # (path, SHA-256) of the model file and its local imports
    declaration: str  # SHA-256 of the declaration
    command: str  # builds the module again
    engine: str = ""  # name and version of the library that derived the equations
    unroll: Unroll = "auto"  # whether kernels are written out, or in loops over tables


def module_text(lowered: Lowered, origin: Origin, module: str = "") -> str:
    """The whole module, signed; of a companion with the SHA-256 of the scene's own, `module`."""
    tables = _tables(lowered, origin)
    if module:
        tables["MODULE_SHA256"] = module
    arguments = Arguments.of(lowered.description)
    return assemble_module(lowered.program, origin, _docstring(lowered), tables, arguments)


def assemble_module(
    program: Program, origin: Origin, docstring: list[str], tables: Mapping[str, Any],
    arguments: Arguments,
) -> str:  # fmt: skip
    """A module from its parts: provenance, docstring, tables, kernels; signed."""
    texts = kernel_texts(program, arguments, origin.unroll)
    tables_of_loops = [line for text in texts for line in text.table_lines()]
    has_arrays = any(text.workspace for text in texts)
    weak = [f"WEAK_PIVOT = {literal(program.weak_pivot)}"]
    generator = " with ".join(filter(None, (origin.generator, origin.engine)))
    lines = [
        f"# Generated by {generator}. Do not edit: change the model, then run",
        f"#     {prose(origin.command)}",
        MARK + UNSIGNED,
        f'"""{prose(docstring[0])}',
        *map(prose, docstring[1:]),
        '"""',
        "",
        "import math  # noqa: F401",
        "",
        "import numba",
        *(["import numpy as np"] if lookups(program) or tables_of_loops or has_arrays else []),
        "",
        *(line for name, value in tables.items() for line in assignment(name, value)),
        "",
        *folded_numbers(program),
        *(weak if any(kernel.watched for kernel in program.kernels) else []),
        f"OPTIONS = {OPTIONS}{'}' if has_arrays else BARE}",
    ]
    lines += spline_lines(program)
    lines += ["", *tables_of_loops] if tables_of_loops else []
    if any(text.has_pairs for text in texts):
        lines += ["", *SIN_COS_FUNCTION.rstrip().split("\n")]
    for text in texts:
        lines += ["", "", *text.lines()]
    return signed(checked(lines))


def operation_table(program: Program) -> tuple[tuple[str, int], ...]:
    """(kernel, operations) of each."""
    return tuple((kernel.name, operations(program, kernel)) for kernel in program.kernels)


# tables that a module leaves out where empty
OPTIONAL = (
    *("folded", "unused", "rigid", "stiction", "shares", "time_functions", "conditions"),
    *("profiles", "peaks", "table_ranges", "states", "sampled", "controllers", "triggers"),
    *("watched", "together", "unknown", "turning", "facing", "redundant"),
)

NAMES = (
    "Names: M_i_k, Phi_c_k, S_c_d are entries of the reduced matrix, Q_i and gamma_c right sides,",
    "pivot_i and inverse_i a pivot and its inverse, L_i_k a multiplier of the elimination, mu_c",
    "the solution of S mu = rhs. minus_x is -x; an entry that changes again takes a number.",
)


ORDERS = {
    "substitute": "first the coordinates that one constraint determines, then the loops",
    "leaves": "body by body from the leaves to the root, then the loops",
    "mixed": "coordinates and constraints in the order of least fill",
    "square": "first the coordinates that one constraint determines, then loop after loop",
    "schur": "accelerations, then S = Φ_q M⁻¹ Φ_qᵀ, in the order of least fill",
}


def _docstring(lowered: Lowered) -> list[str]:
    description = lowered.description
    n, m = len(description.coordinates), len(description.constraints)
    states = len(description.states)
    freedom = counted(max(n - m - states, 0), "degree of freedom")
    freedom += f", {counted(states, 'state')}" if states else ""
    elimination = [f"Elimination: {ORDERS[lowered.strategy]}.", *NAMES] if lowered.strategy else []
    return [
        f"Machine {description.model}, scene {description.scene}: {description.analysis}.",
        "",
        f"{counted(n - states, 'coordinate')}, {counted(m, 'constraint')}, {freedom}.",
        *elimination,
        "SI units. t is the time; q, v, a are coordinates, velocities and accelerations as in",
        "COORDINATES, lam the multipliers of CONSTRAINTS, p PARAMETERS followed by CONSTANTS,",
        "modes the mode of each of SWITCHES: off (0), on (1) or sliding on g = 0 (2).",
    ]


def _with_names_of_tables(
    program: Program, functions: tuple[Any, ...], first: int
) -> tuple[Any, ...]:
    """Rows of operations, from field `first` on, each table in them by its name in the module."""
    names = lookups(program)

    def row(entry: tuple[Any, ...]) -> tuple[Any, ...]:
        *first, last = entry
        if not isinstance(last, Lookup):
            return entry
        known = {look.table: name for look, name in names.items()}
        stem = known[last.table].partition("_d")[0].upper()
        beyond = () if last.table.beyond == "stop" else (last.table.beyond,)
        return (*first, stem, last.order, last.table.periodic, *beyond)

    return tuple((*f[:first], *(tuple(map(row, rows)) for rows in f[first:])) for f in functions)


def _tables(lowered: Lowered, origin: Origin) -> dict[str, Any]:
    """The fields of the description in capitals, and the provenance, kinds and counts."""
    program, description = lowered.program, lowered.description
    tables: dict[str, Any] = {"GENERATOR": origin.generator}
    for field in fields(description):
        name, value = field.name, getattr(description, field.name)
        if isinstance(value, Pattern):
            tables |= value.tables(name.upper())
        elif value is not None and (value or name not in OPTIONAL):
            tables[name.upper()] = value
        match name:
            case "scene":
                tables["FORMULATION"] = "cartesian"
            case "analysis":
                tables |= {"SOURCES": origin.sources, "DECLARATION_SHA256": origin.declaration}
            case "time_functions" if value:
                tables[name.upper()] = _with_names_of_tables(program, value, 3)
            case "table_ranges" if value:
                tables[name.upper()] = _with_names_of_tables(program, value, 5)
            case "folded":
                constants = tuple(formula(program, number) for number in program.constants)
                tables["CONSTANTS"] = constants
    if len(description.recovered) == len(description.constraints):
        del tables["RECOVERED"]
    return {**tables, "OPERATIONS": operation_table(program)}


def tangents_text(lowered: Lowered, program: Program, origin: Origin, module: str) -> str:
    """The module of a scene's exact derivatives, whose kernels take the scene's own ``p``."""
    about = (
        "exact derivatives for implicit methods.",
        "Each kernel differentiates one of the scene's own module along the direction that it is",
        "given, operation by operation, with the modes and parameters held. Arguments in SI units.",
    )
    arguments = Arguments.of(lowered.description)
    return _companion_text(lowered, program, origin, module, about, {}, arguments)


def reduced_text(lowered: Lowered, reduced: Reduced, origin: Origin, module: str) -> str:
    """The module of a scene's reduced equations; in its ``p`` branches precede the constants."""
    description, program = lowered.description, reduced.program
    kept, all_ = (len(x) - len(description.states) for x in (reduced.kept, description.coordinates))
    coordinates = f"{kept} of {all_} coordinates"
    about = (
        "reduced coordinates.",
        f"Left: {coordinates}, {len(reduced.closures)} of {len(description.constraints)} rows.",
        "The kernels are called as those of the scene's own module, of the coordinates",
        "that are left; expand gives all of them. SI units.",
    )
    tables = {
        "FORMULATION": "reduced",
        "KEPT": reduced.kept,
        "CLOSURES": reduced.closures,
        "ANGLES": reduced.angles,
        "BRANCHES": reduced.branches,
        "CONSTANTS": tuple(formula(program, number) for number in program.constants),
        **reduced.jacobian.tables("JACOBIAN"),
        **reduced.mass.tables("MASS"),
    }
    arguments = Arguments.of(description, reduced.kept, len(reduced.branches))
    return _companion_text(lowered, program, origin, module, about, tables, arguments)


def picture_text(lowered: Lowered, picture: LoweredPicture, origin: Origin, module: str) -> str:
    """The module of a scene's picture, whose kernels take the scene's own ``p``."""
    about = (
        "its picture.",
        "picture writes the poses of BODIES and the numbers of SHAPES, in the slots that stand",
        "there, curves the points of curves. SI units.",
    )
    layout = picture.layout
    tables = {
        "LAYOUT": SPACE_VERSION if lowered.scene.turns else VERSION, "BODIES": plain(layout.bodies),
        "SHAPES": plain(layout.shapes),
    }  # fmt: skip
    arguments = Arguments.of(lowered.description)
    # Behind the parameters stand the scene's constants, which are none of the picture's.
    origin = replace(origin, unroll="always")
    return _companion_text(lowered, picture.program, origin, module, about, tables, arguments)


def plain(rows: tuple[Any, ...]) -> tuple[Any, ...]:
    """Nested tuples without the names of their fields."""
    return tuple(plain(row) if isinstance(row, tuple) else row for row in rows)


def _companion_text(
    lowered: Lowered, program: Program, origin: Origin, module: str, about: tuple[str, ...],
    tables: Mapping[str, Any], arguments: Arguments,
) -> str:  # fmt: skip
    model, scene, (first, *more) = lowered.description.model, lowered.description.scene, about
    head: dict[str, Any] = {
        "GENERATOR": origin.generator,
        "MODEL": model,
        "SCENE": scene,
        "SOURCES": origin.sources,
        "DECLARATION_SHA256": origin.declaration,
        "MODULE_SHA256": module,
        **tables,
        "OPERATIONS": operation_table(program),
    }
    docstring = [f"Machine {model}, scene {scene}: {first}", "", *more]
    return assemble_module(program, origin, docstring, head, arguments)
