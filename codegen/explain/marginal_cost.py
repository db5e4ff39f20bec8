"""The marginal cost of an effect: the operations that would be gone without it, by kernel.

Value numbering shares work: a value that an effect needs may already exist for a joint, and the
solution treats its force together with other forces. The operations under an effect's name in the
text (`codegen.lower.operation_count.by_element`) are those that it was the first to need. Its
marginal cost is the kernel's operations less those of the same equations without its terms: an
operation shared with another part does not count, and a sum that loses a term counts as one
operation.
"""

from collections.abc import Collection
from dataclasses import replace

from codegen.derive.equations import Equations
from codegen.derive.switching_functions import held_sides, rigid_contacts, switches
from codegen.lower.kernels.scene_kernels import lower
from codegen.lower.operation_count import operations


def with_effects(equations: Equations, effects: Collection[str]) -> Equations:
    """The equations with only some of their effects; nothing is derived again."""
    chosen = tuple(e for e in equations.effects if e.name in effects)
    named = tuple((e.name, e.terms) for e in chosen)
    found = switches(named)
    return replace(
        equations,
        effects=chosen,
        switches=found,
        sides=held_sides(named, found),
        contacts=rigid_contacts(named, found),
    )


def without_effect(equations: Equations, effect: str) -> Equations:
    """The equations without the terms of one effect."""
    return with_effects(equations, [e.name for e in equations.effects if e.name != effect])


def own_operations(equations: Equations, effect: str) -> dict[str, int]:
    """Kernel → operations that only this effect causes.

    A kernel that exists for the effect alone counts as a whole. The number is negative where the
    effect saves the others work, as a term that cancels another.
    """
    full, rest = (
        {k.name: operations(program, k) for k in program.kernels}
        for program in (lower(equations).program, lower(without_effect(equations, effect)).program)
    )
    return {name: count - rest.get(name, 0) for name, count in full.items()}
