"""Compilation of the runtime into numba's cache ahead of the first run.

It takes half a minute once an installation, which the first run would otherwise wait for.
"""

from importlib import import_module

from runtime.integrate.method import METHODS
from runtime.integrate.wiring import function_table

ALWAYS = (
    "runtime.integrate.run",
    "runtime.dynamics.output_quantities",
    "runtime.continuation.predictor_corrector",
    "runtime.singularity.gauss_newton",
    "runtime.singularity.complement_derivative",
)
SOMETIMES = ("runtime.statics.kinetic_damping",)


def warm(*methods: str) -> None:
    """Compile the modules of every run, and the methods named; without names, all modules."""
    for name in ALWAYS if methods else (*ALWAYS, *SOMETIMES):
        import_module(name)
    for method in methods or METHODS:
        function_table(method)
