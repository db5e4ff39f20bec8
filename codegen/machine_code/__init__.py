"""Machine code: kernels, compiled functions of the runtime, and what is kept on disk.

Kernels are translated here, for LLVM, without numba's analyses, which take four fifths of the time
of compiling a kernel for what kernels do not need. The runtime's functions are numba's own. This is
the only package that imports `numba.core`, `numba.np` or `llvmlite`; what it uses beyond their
documentation, `undocumented_names` imports. `LINKWRIGHT_NUMBA=plain` does without.
"""
