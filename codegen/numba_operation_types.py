"""Types of the results of numba's own operations, which numba finds once a process.

Numba finds the type of each product in a kernel anew: it tries the templates of the operation in
turn, with constants as constants and as any number, and that took two fifths of the time in which
kernels compile. The type depends on nothing but the types of the operands, so it is kept here. It
is not where numba compiles a function for the call, an `overload`, which depends on the options of
the caller as well.
"""

import operator
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import types
from numba.core.types import functions

_Function: Any = functions.BaseFunction  # numba leaves these untyped
_types: Any = types
_OPERANDS = (_types.Number, _types.Boolean, _types.Array)
_INDEXED = (operator.getitem, operator.setitem)

_NEEDED = ("get_call_type", "get_impl_key")
_usual: Any = getattr(_Function, "get_call_type", None)
_known: dict[tuple[Any, ...], Any] = {}  # (operation, context, types of operands) → signature


@contextmanager
def remembered_operation_types() -> Iterator[None]:
    """Within the block, numba finds the type of an operation once for the same operands."""
    if not all(hasattr(_Function, name) for name in _NEEDED):
        yield  # another version of numba: without, kernels compile as fast as it can
        return
    before, _Function.get_call_type = _Function.get_call_type, _get_call_type
    try:
        yield
    finally:
        _Function.get_call_type = before


def _get_call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
    """The signature of a call; an error is found anew each time."""
    if kws or not all(isinstance(kind, _OPERANDS) for kind in args):
        return _usual(self, context, args, kws)
    kinds = args
    if self.typing_key in _INDEXED and isinstance(args[0], _types.Array):
        kinds = tuple(map(_types.unliteral, args))  # each constant index is a type of its own
    key = (self, context, kinds)
    signature = _known.get(key)
    if signature is None:
        signature = _usual(self, context, args, kws)
        if self.get_impl_key(signature) is self.typing_key:  # else the key is an `overload`
            _known[key] = signature
    else:
        self._impl_keys.setdefault(signature.args, self.typing_key)
    return signature
