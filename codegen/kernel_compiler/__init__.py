"""Kernels → machine code without numba's analyses, which take most of its time.

A generated text is Python that numba compiles. Kernels use little of Python: numbers, arrays,
choices, loops with a counter, functions of one another. `function_translation` writes that down in
LLVM's language, operation by operation; `numba_pipeline` hands it to numba, which optimizes it,
keeps it on disk and calls it as any other function. Numba compiles what the translation does not
know.
"""
