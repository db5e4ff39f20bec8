"""Which kernels are written out, operation by operation, and which in loops over tables."""

from typing import Literal

from codegen.emit.argument_docstrings import Arguments
from codegen.emit.kernel import KernelText
from codegen.emit.rolled_kernel import RolledKernelText
from codegen.lower.program import LEAVES, Kernel, Program
from codegen.reroll.rerolling import reroll

Unroll = Literal["auto", "always", "never"]
"""Write kernels out where that is short; always; never: in loops, however few operations."""

LONGEST = 3000  # measured: operations of a kernel that is written out, whatever repeats in it
GAIN = 0.6  # measured: part of a longer kernel's operations that its loops may have in the text


def kernel_text(
    program: Program, kernel: Kernel, arguments: Arguments, unroll: Unroll
) -> KernelText | RolledKernelText:
    """The text of a kernel, written out or in loops.

    Straight code is up to twice as fast where a machine is small; from some forty bodies on it is
    no faster than loops, while its compilation takes minutes.
    """
    has_workspace = "p" in kernel.arguments
    count = _count(program, kernel)
    if unroll == "always" or not has_workspace or (unroll == "auto" and count <= LONGEST):
        return KernelText(program, kernel, arguments)
    slots = arguments.slots(program)
    constants = {k: slots[k] for k in program.hoisted(kernel)}
    base = arguments.declared + len(program.constants)
    rolled = reroll(program, kernel, constants, base)
    if unroll == "auto" and rolled.statements > GAIN * count:
        return KernelText(program, kernel, arguments)
    return RolledKernelText(program, kernel, rolled, arguments)


def _count(program: Program, kernel: Kernel) -> int:
    """Operations of a kernel, negations and choices among them."""
    hoisted = program.hoisted(kernel)
    reachable = program.reachable(kernel)
    return sum(program.values[k].op not in LEAVES and k not in hoisted for k in reachable)
