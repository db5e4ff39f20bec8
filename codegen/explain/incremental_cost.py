"""Incremental costs: a scene assembled part by part, its parts' costs differences of programs.

Effects are added one after another in the order of their declaration, first to the joints, drivers
and masses alone; the last of these programs is the scene's. An increment depends on the parts
before it (a sum of two forces costs one operation, whichever came first), but the increments add up
to the whole exactly, in operations and in time.
"""

from dataclasses import dataclass

from codegen.derive.equations import Equations
from codegen.explain.marginal_cost import with_effects
from codegen.lower.kernels.scene_kernels import Lowered, lower
from codegen.lower.operation_count import by_element, operations
from codegen.lower.program import Kernel, Output, Program

Counts = dict[str, dict[str, int]]
"""Part → kernel → operations."""

SOLUTION = "factorization"
"""The part of `accelerations` that solves the equations: the operations that serve no element."""


@dataclass(frozen=True)
class Stage:
    """A kernel `accelerations` with the work of the stage before it and of one more part.

    Attributes
    ----------
    part
        An element, or ``"factorization"``.
    program
        The kernels ``constants`` and ``accelerations``.
    """

    part: str
    program: Program


def cumulative_programs(equations: Equations) -> tuple[Lowered, ...]:
    """The scene with none of its effects, with the first, with the first two … with all."""
    names = [effect.name for effect in equations.effects]
    return tuple(lower(with_effects(equations, names[:k])) for k in range(len(names) + 1))


def operations_by_part(equations: Equations, programs: tuple[Lowered, ...]) -> Counts:
    """Operations of each part; in each kernel they add up to the kernel's total.

    Joints, drivers and shared work are counted in the scene without effects, each operation for the
    element that needed it first. An effect counts the growth of each kernel when it joins those
    before it, which is negative where it saves the others work.
    """
    found: Counts = {}
    totals: dict[str, int] = {}
    bare = programs[0].program
    for kernel in bare.kernels:
        for part, count in by_element(bare, kernel).items():
            found.setdefault(part, {})[kernel.name] = count
    totals = operations_of(programs[0])
    for effect, lowered in zip(equations.effects, programs[1:], strict=True):
        after = operations_of(lowered)
        added = {k: after.get(k, 0) - totals.get(k, 0) for k in {**totals, **after}}
        found[effect.name] = {kernel: count for kernel, count in added.items() if count}
        totals = after
    for kernel_name in totals:
        parts = sum(counts.get(kernel_name, 0) for counts in found.values())
        assert parts == totals[kernel_name], (kernel_name, parts, totals[kernel_name])
    return found


def operations_of(lowered: Lowered) -> dict[str, int]:
    """Kernel → arithmetic operations."""
    program = lowered.program
    return {k.name: operations(program, k) for k in program.kernels}


def timing_stages(equations: Equations, programs: tuple[Lowered, ...]) -> tuple[Stage, ...]:
    """The kernel `accelerations`, from the first joint's terms to all; empty without one.

    The stage of a joint computes its entries of Φ_q and γ and those of the joints before it, and
    stores the values that the rest of the kernel would read. The whole kernel without effects
    follows, then one more effect a stage.
    """
    first = programs[0].program
    names = {kernel.name for kernel in programs[-1].program.kernels}
    if "accelerations" not in names or "accelerations" not in {k.name for k in first.kernels}:
        return ()
    (whole,) = (k for k in first.kernels if k.name == "accelerations")
    found: list[Stage] = []
    met: set[str] = set()
    before = 0
    for constraint in equations.constraints:
        met.add(constraint.name)
        kernel = _terms(first, whole, frozenset(met))
        if operations(first, kernel) > before:  # without an operation of its own it takes no time
            found.append(Stage(constraint.name, _alone(first, kernel)))
            before = operations(first, kernel)
    found.append(Stage(SOLUTION, _alone(first, whole)))
    for effect, lowered in zip(equations.effects, programs[1:], strict=True):
        program = lowered.program
        (kernel,) = (k for k in program.kernels if k.name == "accelerations")
        found.append(Stage(effect.name, _alone(program, kernel)))
    return tuple(found)


def _alone(program: Program, kernel: Kernel) -> Program:
    kept = tuple(k for k in program.kernels if k.name == "constants")
    return Program(program.values, (*kept, kernel), program.constants, program.weak_pivot)


def _terms(program: Program, whole: Kernel, owners: frozenset[str]) -> Kernel:
    """A kernel of the contributions of some elements to `whole`."""
    hoisted = set(program.constants)
    roots = [
        number
        for number in program.reachable(whole)
        if number not in hoisted
        and program.values[number].serves in owners
        and program.values[number].args
    ]
    every = tuple(Output("lam", 0, number) for number in roots)
    inside = Kernel(whole.name, whole.summary, whole.arguments, every)
    read = {
        argument
        for number in program.reachable(inside)
        if number not in hoisted
        for argument in program.values[number].args
    }
    ends = [number for number in roots if number not in read]
    outputs = tuple(Output("lam", slot, number) for slot, number in enumerate(ends))
    return Kernel(whole.name, whole.summary, whole.arguments, outputs, (), watched=True)
