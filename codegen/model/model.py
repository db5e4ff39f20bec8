"""The declaration of a machine: bodies, parameters, joints, drivers, effects and scenes.

A declaration never raises for a wrong element: every problem is noted, and `build` reports all
of them at once (`codegen.check.declaration`).
"""

from typing import Any, TypeVar

from codegen.declare.body import Body
from codegen.declare.element import Constraint, Effect
from codegen.elements.registry import role
from codegen.model.cams import Cams
from codegen.model.contacts_and_friction import Contacts
from codegen.model.drivers import Drivers
from codegen.model.forces import Forces
from codegen.model.parameters_and_tables import Values
from codegen.model.scene_variations import Variations

Element = TypeVar("Element", bound=Constraint | Effect | Body)


class Model(Values, Variations, Cams, Drivers, Forces, Contacts):
    """A planar machine.

    Parameters
    ----------
    name
        An identifier; begins the names of the generated files.
    gravity
        (g_x, g_y) in m/s²; declares the effect ``"gravity"``. Other gravities: `Model.gravity`.

    Examples
    --------
    >>> model = Model("pendulum", gravity=(0, -9.81))
    >>> bob = model.body("bob", mass=1.0, inertia=0.1)
    >>> hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    >>> swing = model.scene("swing", effects=["gravity"], start={"bob.phi": 0})
    """

    def __init__(self, name: str, gravity: tuple[Any, Any] | None = None) -> None:
        super().__init__(name)
        if gravity is not None:
            self.gravity("gravity", gravity)

    def add(self, element: Element) -> Element:
        """Declare a user-defined element: a `Constraint`, an `Effect` or a kind of `Body`.

        A body takes ``model.token`` as its `model`.
        """
        if isinstance(element, Body):
            if self._claim("body", element.name):
                self.bodies[element.name] = element
            return element
        if isinstance(element, Constraint):
            is_driver = role(element.kind) == "driver"
            return self._driver(element) if is_driver else self._joint(element)
        candidate: object = element
        if isinstance(candidate, Effect):
            self._effect(candidate)
            return element
        self._note(
            f"model.add({element!r}): neither a Body, a Constraint nor an Effect; it needs kind, "
            "name, bodies, problems(), and statement() or potential() and forces()."
        )
        return element
