"""Which kernels are written out, operation by operation, and which in loops over tables."""

from typing import Literal

from codegen.emit.kernel import KernelText
from codegen.emit.kernel_docstrings import Arguments
from codegen.emit.rolled_kernel import RolledKernelText
from codegen.lower.program import LEAVES, Kernel, Program
from codegen.reroll.batching import batch
from codegen.reroll.rerolling import reroll

Unroll = Literal["auto", "always", "never"]
"""Write kernels out where that is short; always; never: in loops, however few operations."""

LONGEST = 6000  # measured: statements of a module that is written out, whatever repeats in it
SHORTEST = 100  # measured: statements of a kernel that is written out in any module
GAIN = 0.6  # measured: part of a kernel's statements that its loops may have in the text
LONGEST_KERNEL = 3000  # measured: statements of a kernel, beyond which it is in batches

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
    """The text of a kernel in loops, or what else is shorter for its `size`.

    A kernel without a period is written out where it is short, and in batches otherwise: those take
    a few hundred lines, whatever the machine, and their time is that of straight code where this is
    long.
    """
    slots = arguments.slots(program)
    constants = {k: slots[k] for k in program.hoisted(kernel)}
    base = arguments.declared + len(program.constants)
    rolled = reroll(program, kernel, constants, base)
    if rolled.statements > LONGEST_KERNEL:
        rolled = batch(program, kernel, constants, base)
    if size is not None and rolled.statements > GAIN * size:
        return KernelText(program, kernel, arguments)
    return RolledKernelText(program, kernel, rolled, arguments)


def statements(program: Program, kernel: Kernel) -> int:
    """Operations and outputs of a kernel, negations and choices among them."""
    counts = program.counts(kernel).items()
    return sum(count for op, count in counts if op not in LEAVES) + len(kernel.outputs)
