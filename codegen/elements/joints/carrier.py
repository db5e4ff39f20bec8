"""The body that carries the bearings of two wheels, against which a transmission turns them."""

from collections.abc import Mapping

import sympy

from codegen.declare.body import Body, Ground
from codegen.declare.element import Constraint, label
from codegen.declare.element_conditions import Condition, number_problems, sign_conditions
from codegen.drawing import shapes
from codegen.elements.joints.gear import find_carrier
from codegen.elements.joints.revolute import Revolute


class WheelPair:
    """Two wheels whose bearings are on a carrier, as the fields of an element."""

    i: Body
    j: Body
    carrier: Body
    radius_i: sympy.Expr
    radius_j: sympy.Expr
    joints: Mapping[str, Constraint]

    def problems(self) -> list[str]:
        """Wheels without an angle, a wheel for its own carrier, other bearings, wrong numbers."""
        where, bodies = label(self), (self.i, self.j, self.carrier)
        problems = [
            f"{where} needs the angle of '{body.name}', which has none; use a body with an angle."
            for body in bodies
            if body.angle is None or not body.turns
        ]
        i, j, carrier = bodies
        if i is j:
            problems.append(f"{where} is between body '{i.name}' and itself; give two.")
        elif isinstance(carrier, Ground) and (carrier is i or carrier is j):
            problems.append(
                f"{where}: the ground is one of its wheels and, as no carrier is given, carries "
                "the bearings too; give two bodies that turn, or as carrier= an arm that turns."
            )
        elif carrier is i or carrier is j:
            problems.append(
                f"{where}: the carrier '{carrier.name}' is one of its wheels; give the body that "
                "carries the bearings, or leave it out for the ground."
            )
        else:
            known = _carriers(i, j, self.joints)
            found = [body for body in known if body is not i and body is not j]
            if found and not any(body is carrier for body in found):
                problems.append(
                    f"{where} turns against '{carrier.name}', but the bearings of '{i.name}' and "
                    f"'{j.name}' are on '{found[0].name}'; give carrier= that body."
                )
        return problems + number_problems(self)


def pulleys_and_belt(pair: WheelPair, crossed: bool) -> tuple[shapes.Shape, ...]:
    """What a belt drive looks like."""
    i, j, radius_i, radius_j = pair.i, pair.j, pair.radius_i, pair.radius_j
    belt = shapes.Belt(i, j, radius_i, radius_j, crossed)
    return shapes.Wheel(i, radius_i), shapes.Wheel(j, radius_j), belt


def radius_conditions(i: sympy.Expr, j: sympy.Expr) -> tuple[Condition, ...]:
    """Two pulleys."""
    return sign_conditions(
        ("radius of the first pulley", i, "m"),
        ("radius of the second pulley", j, "m"),
        positive=True,
    )


def _carriers(i: Body, j: Body, joints: Mapping[str, Constraint]) -> list[Body]:
    """The bodies that revolute joints show to carry both wheels, coaxial bodies included."""
    pins = [pin for pin in joints.values() if isinstance(pin, Revolute)]
    ends = [end for pin in pins for end in (pin.i, pin.j)]
    found = (
        find_carrier(one, other, joints)
        for one in ends
        if one.body is i
        for other in ends
        if other.body is j
    )
    return [carrier[0] for carrier in found if carrier is not None]
