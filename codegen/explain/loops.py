"""The sentence about kernels in loops: which, and why."""

from codegen.emit.argument_docstrings import Arguments
from codegen.emit.rolled_kernel import RolledKernelText
from codegen.emit.unrolling import LONGEST, kernel_texts, statements
from codegen.lower.kernels.scene_kernels import Lowered


def loops_sentence(lowered: Lowered) -> str:
    """Which kernels a build has in loops, their statements before and after; or why none is."""
    program = lowered.program
    sizes = {kernel.name: statements(program, kernel) for kernel in program.kernels}
    total = sum(sizes.values())
    if total <= LONGEST:
        return f"written out: {total} statements, not above {LONGEST}"
    texts = kernel_texts(program, Arguments.of(lowered.description), "auto")
    rolled = [
        f"{text.kernel.name} ({sizes[text.kernel.name]} statements, {text.rolled.statements} left)"
        for text in texts
        if isinstance(text, RolledKernelText)
    ]
    head = f"{total} statements, above {LONGEST}"
    if not rolled:
        return f"written out: {head}, but no kernel repeats itself"
    return f"in loops: {', '.join(rolled)}: {head}; written out: what repeats too little"
