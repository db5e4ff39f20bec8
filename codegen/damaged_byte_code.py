"""Byte code of our own packages: thrown away where it is damaged.

Python looks at the first 16 bytes of a file in `__pycache__` before it trusts the rest. One that is
cut short, as a full disk leaves it, ends every later import of its module.

This is imported before a command has put the working folder last, in which a file may have the name
of any module: it takes only what Python itself has loaded.
"""

import os
import sys
from _frozen_importlib_external import PathFinder, SourceFileLoader

TYPE_CHECKING = False  # type checkers take it as true; importing typing would load modules
if TYPE_CHECKING:
    from collections.abc import Sequence
    from importlib.machinery import ModuleSpec
    from types import CodeType, ModuleType


class CacheWarning(UserWarning):
    """Compiled code on the disk is damaged or cannot be kept, and is made anew."""


_PACKAGES = {"codegen", "runtime", "linkwright", "generated", "models"}
_BESIDE = {"codegen", "runtime", "linkwright"}
"""Those that a file in the user's folder does not replace."""
_LIBRARY = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))  # noqa: PTH100, PTH120


class _Finder:
    """Finds modules as Python does, and loads those of our packages with care."""

    @staticmethod
    def find_spec(
        name: str, path: "Sequence[str] | None" = None, target: "ModuleType | None" = None
    ) -> "ModuleSpec | None":
        """The specification of a module of ours; None for all others."""
        if name.partition(".")[0] not in _PACKAGES:
            return None
        spec = PathFinder.find_spec(name, [_LIBRARY] if name in _BESIDE else path, target)
        if spec is not None and type(spec.loader) is SourceFileLoader:
            spec.loader = _Loader(spec.loader.name, spec.loader.path)
        return spec


class _Loader(SourceFileLoader):
    """Python's own loader, to which damaged byte code is none."""

    def get_code(self, fullname: str) -> "CodeType | None":
        """The module's code, compiled anew where its byte code cannot be read."""
        try:
            return super().get_code(fullname)
        except (EOFError, ValueError, TypeError, ImportError) as error:
            from importlib.util import cache_from_source
            from warnings import warn

            damaged = cache_from_source(self.path)
            try:
                os.unlink(damaged)  # noqa: PTH108
            except OSError:
                raise error from None
            code = super().get_code(fullname)
            warn(f"{damaged}: damaged byte code ({error}) is made anew.", CacheWarning, 2)
            return code


def mend_imports() -> None:
    """Load modules of our packages with care from now on."""
    if _Finder not in sys.meta_path:
        sys.meta_path.insert(0, _Finder)


def keep_no_byte_code(spec: "ModuleSpec | None") -> None:
    """Remove the byte code of a module that Python loads before `mend_imports` is called."""
    try:
        os.unlink(spec.cached)  # type: ignore[union-attr,arg-type]  # noqa: PTH108
    except (OSError, TypeError, AttributeError):  # there is none, or it may not be removed
        return


mend_imports()
keep_no_byte_code(__spec__)
