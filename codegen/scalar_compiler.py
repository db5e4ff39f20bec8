"""Numba's passes for code that makes no arrays: those that have something to do there.

Such code is loops over scalars and elements. It has no closure, `with` or `literal_unroll`, no
expression of whole arrays and nothing that asks to be inlined before its types are known, but numba
looks for all of these, and each search goes through the whole function. Code that has one of them
does not compile with these passes.
"""

from typing import Any

from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager
from numba.core.typed_passes import InlineOverloads, NopythonRewrites
from numba.core.untyped_passes import (
    FindLiterallyCalls,
    InlineClosureLikes,
    InlineInlinables,
    LiteralPropagationSubPipelinePass,
    LiteralUnroll,
    MakeFunctionToJitFunction,
    WithLifting,
)

_Compiler: Any = CompilerBase  # numba leaves these untyped
_builder: Any = DefaultPassBuilder
_Passes: Any = PassManager

_IDLE = frozenset(
    {
        FindLiterallyCalls, InlineClosureLikes, InlineInlinables, InlineOverloads,
        LiteralPropagationSubPipelinePass, LiteralUnroll, MakeFunctionToJitFunction,
        NopythonRewrites, WithLifting,
    }
)  # fmt: skip


class ScalarCompiler(_Compiler):  # type: ignore[misc]
    """A compiler of functions of scalars and elements of arrays."""

    def define_pipelines(self) -> list[Any]:
        """Numba's usual passes, without the idle ones."""
        usual = _builder.define_nopython_pipeline(self.state)
        passes = _Passes("scalar")
        passes.passes = [step for step in usual.passes if step[0] not in _IDLE]
        passes.finalize()
        return [passes]
