"""Operations of the parts of a scene, as differences of programs.

Incremental costs add up to the whole exactly, in operations and in time: effects are added one
after another in the order of their declaration, first to the joints, drivers and masses alone; the
last of these programs is the scene's. An increment depends on the parts before it: a sum of two
forces costs one operation, whichever came first.

The marginal cost of an effect is the number of operations that would be gone without it. Value
numbering shares work: a value that an effect needs may already exist for a joint, and the solution
treats its force together with other forces. The operations under an effect's name in the text
(`codegen.lower.operation_count.by_element`) are those that it was the first to need. Its marginal
cost is the kernel's operations less those of the same equations without its terms: an operation
shared with another part does not count, and a sum that loses a term counts as one operation.
"""

from collections.abc import Collection
from dataclasses import replace
from typing import NamedTuple

from codegen.lower.lowered_scene import Lowered, lower
from codegen.lower.operation_count import by_element, operations
from codegen.lower.program import Kernel, Output, Program

Counts = dict[str, dict[str, int]]  # part → kernel → operations

SOLUTION = "factorization"
"""The part of `accelerations` that solves the equations: the operations that serve no element."""


class Stage(NamedTuple):
    """`constants` and a kernel `accelerations` with the work of all stages up to that of `part`."""

    part: str
    program: Program


def operations_of(lowered: Lowered) -> dict[str, int]:
    """Kernel → arithmetic operations."""
    return {name: operations(lowered.program, k) for name, k in lowered.kernels.items()}


def marginal_operations(lowered: Lowered, effect: str) -> dict[str, int]:
    """Kernel → operations that only this effect of a scene causes.

    A kernel that exists for the effect alone counts as a whole, and so do the states that nothing
    else needs. The number is negative where the
    effect saves the others work, as a term that cancels another.
    """
    equations = lowered.scene.equations.without_effect(effect)
    rest = operations_of(lower(equations, lowered.shared))
    return {name: count - rest.get(name, 0) for name, count in operations_of(lowered).items()}


def cumulative_programs(whole: Lowered) -> tuple[Lowered, ...]:
    """The scene with none of its effects, with the first, with the first two … with all."""
    equations = whole.scene.equations
    effects = equations.effects
    fewer = (equations.with_effects(effects[:k]) for k in range(len(effects)))
    return (*(lower(part, whole.shared) for part in fewer), whole)


def operations_by_part(programs: tuple[Lowered, ...]) -> Counts:
    """Operations of each part; in each kernel they add up to the kernel's total.

    Joints, drivers and shared work are counted in the scene without effects, each operation for the
    element that needed it first. An effect counts the growth of each kernel when it joins those
    before it, which is negative where it saves the others work.
    """
    by_part: Counts = {}
    bare = programs[0].program
    for kernel in bare.kernels:
        for part, count in by_element(bare, kernel).items():
            by_part.setdefault(part, {})[kernel.name] = count
    totals = operations_of(programs[0])
    for lowered in programs[1:]:
        after = operations_of(lowered)
        added = {k: after.get(k, 0) - totals.get(k, 0) for k in {**totals, **after}}
        effect = lowered.scene.equations.effects[-1].name
        so_far = by_part.setdefault(effect, {})  # a point may have the name of a joint
        so_far |= {k: so_far.get(k, 0) + count for k, count in added.items() if count}
        totals = after
    for name, total in totals.items():
        parts = sum(counts.get(name, 0) for counts in by_part.values())
        assert parts == total, (name, parts, total)
    return by_part


def timing_stages(programs: tuple[Lowered, ...]) -> tuple[Stage, ...]:
    """The kernel `accelerations`, from the first joint's terms to all; empty without one.

    The stage of a joint computes its entries of Φ_q and γ and those of the joints before it, and
    stores the values that the rest of the kernel would read. The whole kernel without effects
    follows, then one more effect a stage.
    """
    bare, whole = programs[0], programs[0].kernels.get("accelerations")
    if whole is None or "accelerations" not in programs[-1].kernels:
        return ()
    stages: list[Stage] = []
    owners: set[str] = set()
    before = 0
    for constraint in bare.scene.equations.constraints:
        owners.add(constraint.name)
        kernel = _terms(bare.program, whole, owners)
        after = operations(bare.program, kernel)
        if after > before:  # without an operation of its own it takes no time
            stages.append(Stage(constraint.name, _alone(bare, kernel)))
            before = after
    stages.append(Stage(SOLUTION, _alone(bare, whole)))
    for lowered in programs[1:]:
        effect = lowered.scene.equations.effects[-1].name
        stages.append(Stage(effect, _alone(lowered, lowered.kernels["accelerations"])))
    return tuple(stages)


def _alone(lowered: Lowered, kernel: Kernel) -> Program:
    kept = tuple(k for k in lowered.program.kernels if k.name == "constants")
    return replace(lowered.program, kernels=(*kept, kernel))


def _terms(program: Program, whole: Kernel, owners: Collection[str]) -> Kernel:
    """A kernel of the contributions of some elements to `whole`."""

    def storing(numbers: list[int]) -> Kernel:
        outputs = tuple(Output("lam", slot, number) for slot, number in enumerate(numbers))
        return Kernel(whole.name, whole.summary, whole.arguments, outputs, watched=True)

    hoisted = set(program.constants)
    roots = [
        number
        for number in program.reachable(whole)
        if number not in hoisted
        and program.values[number].serves in owners
        and program.values[number].args
    ]
    read = {
        argument
        for number in program.reachable(storing(roots))
        if number not in hoisted
        for argument in program.values[number].args
    }
    return storing([number for number in roots if number not in read])
