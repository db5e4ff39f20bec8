"""Distance driver: the distance of two points follows a law of time (Haug, section 3.5)."""

import sympy

from codegen.declare.body import Point
from codegen.declare.element import ConjugateReaction, I, J, Statement
from codegen.declare.element_conditions import Condition, number_problems
from codegen.declare.symbols import t
from codegen.drawing import shapes
from codegen.elements.drivers.driver_base_class import Driver
from codegen.elements.registry import element

# safety: (1e-90 m)² is lost in the rounding of any distance, and keeps d / |d| and its derivative
# from 0 / 0 where a guess puts both points in one place: the Jacobian is 0 there, as that of dᵀ d
# is.
NOTHING = 1e-180
SPAN = J.point - I.point
DISTANCE = sympy.sqrt(SPAN.dot(SPAN) + NOTHING)


@element(driver=True)
class DistanceDriver(Driver):
    """sqrt(dᵀ d) - C(t) = 0 with d = r_j^P - r_i^P: a cylinder or a winch between two points.

    Haug squares both sides. Here the distance itself is driven, so that the multiplier is a force,
    and a law below 0 has no solution instead of that of its opposite. Where C reaches 0 the two
    points meet, the direction between them is lost and the machine locks; a stroke that passes
    through 0 is one of `TranslationDriver` or `RelativeDriver`.

    The reaction is the force on body j away from point i, N; body i gets the opposite: positive
    where the driver pushes the points apart.
    """

    kind = "distance driver"
    example = 'model.distance_driver("cylinder", P, Q, 2 + sin(3 * t) / 2)'
    name: str
    i: Point
    j: Point
    law: sympy.Expr

    def statement(self) -> Statement:
        """One equation, m."""
        reaction = ConjugateReaction((("force", "N"),))
        bindings = I.bind(self.i) | J.bind(self.j)
        return Statement((DISTANCE - self.law,), ("distance",), reaction, bindings)

    def problems(self) -> list[str]:
        """The law is one of time, and positive as far as can be told: always, or at t = 0."""
        return super().problems() or number_problems(self)

    def conditions(self) -> tuple[Condition, ...]:
        """A law that is positive at t = 0."""
        law = str(self.law).replace("{", "{{").replace("}", "}}")
        text = (
            f"the law {law} is {{:g}} m at t = 0; a distance stays positive: where two points pass "
            "each other drive with model.translation_driver or model.relative_driver."
        )
        return (Condition(text, (self.law.subs(t, 0),), open=True),)

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """An actuator."""
        return (shapes.Spring(self.i, self.j, elastic=False, actuator=True),)
