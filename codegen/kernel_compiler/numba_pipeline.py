"""What numba calls to compile a kernel, in the place of its own compiler.

Numba's own analyses Python's byte code, finds types and makes an object of each instruction. Before
that it reads its types of all of NumPy, and SciPy with them.
"""

from types import FunctionType
from typing import Any

from numba.core import compiler

_Usual: Any = compiler.Compiler  # numba leaves it untyped


class KernelCompiler:
    """Compiles one function, as `numba.core.compiler.CompilerBase` does."""

    def __init__(self, *state: Any) -> None:
        self._state = state

    def compile_extra(self, function: FunctionType) -> Any:
        """The result; numba itself compiles what is no kernel of an imported text."""
        from codegen.kernel_compiler.compilation_result import compile_kernel
        from codegen.kernel_compiler.llvm_instructions import UntranslatableError

        try:
            return compile_kernel(self._state, function)
        except (UntranslatableError, RecursionError):  # the latter, where a text nests too deeply
            return _Usual(*self._state).compile_extra(function)
