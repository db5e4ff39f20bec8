"""Compile the runtime into numba's cache, where it is not there yet.

It takes half a minute, once an installation; whoever runs a machine for the first time would wait
for it then.
"""

from importlib import import_module

from runtime.integrate.tables import METHODS, function_table

ALWAYS = (
    "runtime.integrate.run",
    "runtime.analyses.outputs",
    "runtime.analyses.walking",
    "runtime.constraints.roots",
    "runtime.constraints.bending",
)
SOMETIMES = ("runtime.analyses.settling",)


def warm(*methods: str) -> None:
    """Compile what every run needs, and the methods named; without names, everything."""
    for name in ALWAYS if methods else (*ALWAYS, *SOMETIMES):
        import_module(name)
    for method in methods or METHODS:
        function_table(method)
