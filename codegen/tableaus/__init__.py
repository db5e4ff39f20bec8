"""Explicit Runge-Kutta methods as data, one file each.

A new method is a file here that sets `TABLEAU`, and one line in `runtime.integrate.method`; then
``python -m codegen methods`` writes its code. The order conditions are tested from the data.
"""

from importlib import import_module
from pkgutil import iter_modules

from codegen.tableaus.tableau import Tableau


def tableaus() -> dict[str, Tableau]:
    """Every method by its name, which is that of its file."""
    modules = (import_module(f"{__name__}.{found.name}") for found in iter_modules(__path__))
    return {m.__name__.rpartition(".")[2]: m.TABLEAU for m in modules if hasattr(m, "TABLEAU")}
