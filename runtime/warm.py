"""Importing this module compiles all of the runtime into numba's cache, where it is not there yet.

It takes some twenty seconds, once an installation; whoever runs a machine for the first time would
wait for it then.
"""

from runtime.analyses import outputs, settling, walking
from runtime.integrate import run
from runtime.integrate.tables import METHODS, function_table

TABLES = tuple(function_table(name) for name in METHODS)

__all__ = ["TABLES", "outputs", "run", "settling", "walking"]
