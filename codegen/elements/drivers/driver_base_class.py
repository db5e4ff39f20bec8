"""The base of all drivers: its law is one of time alone (Haug 3.5)."""

import sympy

from codegen.declare.element import Constraint, label
from codegen.declare.symbols import Coordinate, kinds, t


class Driver(Constraint):
    """A driver: driven - law(t) = 0."""

    law: sympy.Expr

    def problems(self) -> list[str]:
        """A law that contains coordinates is no law of time."""
        return [
            f"{label(self)}: the law {self.law} contains the coordinate {s.name}; "
            f"a motion law depends on {t} and parameters only."
            for s in kinds(self.law, Coordinate)
        ]
