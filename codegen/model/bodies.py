"""The bodies of a declaration."""

from typing import Any

import sympy

from codegen.declare.body import Body, Particle
from codegen.model.base import Declarations


class Bodies(Declarations):
    """The bodies and particles of a declaration."""

    def body(self, name: str, mass: Any = None, inertia: Any = None) -> Body:
        """A rigid body with its centre of mass at its origin.

        Parameters
        ----------
        name
            An identifier.
        mass, inertia
            Numbers in kg and kg m², pint quantities, parameters or expressions of them; may be
            left out where only kinematic scenes use the body.
        """
        m = self._positive(mass, "kg", f"mass of body '{name}'")
        j = self._positive(inertia, "kg m^2", f"inertia of body '{name}'")
        body = Body(str(name), m, j, self.token)
        if self._claim("body", name):
            self.bodies[name] = body
        return body

    def particle(self, name: str, mass: Any = None) -> Particle:
        """A point mass, with two coordinates and no orientation.

        Parameters
        ----------
        name
            An identifier.
        mass
            A number in kg, a pint quantity, a parameter or an expression of them; may be left out
            where only kinematic scenes use the particle.
        """
        m = self._positive(mass, "kg", f"mass of particle '{name}'")
        particle = Particle(str(name), m, None, self.token)
        if self._claim("particle", name):
            self.bodies[name] = particle
        return particle

    def _positive(self, value: Any, unit: str, where: str) -> sympy.Expr | None:
        """A mass or inertia, if given; a parameter that is one must be positive from now on."""
        if value is None:
            return None
        before = len(self.problems)
        read = self._value(value, unit, where, "positive")
        return read if len(self.problems) == before else None
