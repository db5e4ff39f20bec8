"""Linkwright, a compiler for mechanisms, under one name.

    import linkwright as lw

    model = lw.Model("pendulum", gravity=(0, -9.81))
    ...
    result = lw.load("pendulum.py").simulate(t_end=10.0)

Here is everything that `codegen` (declarations, in SymPy) and `runtime` (analyses, in numba) make
public. A name loads its module when it is first used: `lw.load` and all that it does import no
SymPy, unless a machine must be built. Both packages are those beside this one, also where the
user's folder has a file `codegen.py` or `runtime.py`.
"""

import os
import sys

_LIBRARY = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))  # noqa: PTH100, PTH120 (no import)

sys.path.insert(0, _LIBRARY)
try:
    import codegen
    import runtime
finally:
    sys.path.remove(_LIBRARY)

for _package in (codegen, runtime):
    if os.path.dirname(os.path.dirname(str(_package.__file__))) != _LIBRARY:  # noqa: PTH120
        raise ImportError(
            f"'{_package.__name__}' is the name of a package of Linkwright, but "
            f"{_package.__file__} was imported by that name before; rename that file, or import "
            "linkwright first."
        )

TYPE_CHECKING = False  # type checkers take it as true; importing typing would load modules
if TYPE_CHECKING:
    from codegen import *  # noqa: F403
    from runtime import *  # noqa: F403

__all__: list[str] = []
__all__ += codegen.__all__
__all__ += runtime.__all__


def __getattr__(name: str) -> object:
    for package in (codegen, runtime):
        if name in package.__all__:
            value = getattr(package, name)
            globals()[name] = value
            return value
    if name.startswith("_"):  # which Python itself asks for
        raise AttributeError(f"module 'linkwright' has no attribute {name!r}")
    from codegen.readers.values import nearest

    raise AttributeError(f"module 'linkwright' has no attribute {name!r}; {nearest(name, __all__)}")


def __dir__() -> list[str]:
    return sorted(__all__)
