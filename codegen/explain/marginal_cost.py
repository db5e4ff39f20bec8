"""What an effect costs by itself: its own operations, kernel by kernel.

Value numbering shares work: what an effect needs may stand there for a joint already, and what the
solution does with its force it does with other forces too. So the operations that bear an effect's
name in the text (`codegen.lower.operation_count.by_element`) are those that it was the first to
need. Its own are those that would be gone without it: the kernel's operations less those of the
same equations without its terms. An operation shared with another part is nobody's own, and a sum
that goes on without the effect counts as the one term less that it is.
"""

from collections.abc import Collection
from dataclasses import replace

from codegen.derive.equations import Equations
from codegen.derive.switching_functions import held_sides, rigid_contacts, switches
from codegen.lower.kernels.scene_kernels import lower
from codegen.lower.operation_count import operations


def acting(equations: Equations, effects: Collection[str]) -> Equations:
    """The equations with some of their effects alone; nothing is derived again."""
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


def less(equations: Equations, effect: str) -> Equations:
    """The equations without the terms of one effect."""
    return acting(equations, [e.name for e in equations.effects if e.name != effect])


def own_operations(equations: Equations, effect: str) -> dict[str, int]:
    """Kernel → the operations that only this effect is the cause of.

    Kernels that are there for the effect alone count with all that they hold. The number is
    negative where the effect spares the others work, as a term that cancels another.
    """
    full, rest = (
        {k.name: operations(program, k) for k in program.kernels}
        for program in (lower(equations).program, lower(less(equations, effect)).program)
    )
    return {name: count - rest.get(name, 0) for name, count in full.items()}
