"""How much has been derived in this process: what scenes share is derived once."""

from codegen.derive.constraints import derived_statements
from codegen.derive.effects import derived_effects
from codegen.derive.switching_functions import rate


def derivations() -> int:
    """Statements, potentials, forces and switching functions that SymPy has worked on so far."""
    return derived_statements() + derived_effects() + rate.cache_info().misses
