"""Force along the line of two points: a cylinder, a cable, a magnet (Haug 6.1)."""

import sympy

from codegen.declare.body import Body, Point
from codegen.declare.element import Effect, Pulls, label
from codegen.drawing import shapes
from codegen.elements.forces.scalar_measures import SpanMeasures, line_problems
from codegen.elements.registry import element


@element
class LineForce(SpanMeasures, Effect):
    """A force f along the line of two points, N, positive where it pulls them together.

    f may be any expression, of the length ℓ and its rate ℓ̇ too. It has no potential, and its power
    is -f ℓ̇. At ℓ = 0 the line has no direction, and a run stops there as not finite.
    """

    kind = "line force"
    example = """
        p = model.table("p", [0, 1, 2, 3, 4], [9e3, 4e3, 2e3, 1e3, 5e2], units=("m", "N"))
        model.line_force("cylinder", P, Q, lambda length, rate: -p(length) + 30 * rate)
    """
    name: str
    i: Point
    j: Point
    value: sympy.Expr

    def pulls(self, bodies: tuple[Body, ...]) -> Pulls:
        """f along ℓ."""
        return ((self.length, self.value),)

    def problems(self) -> list[str]:
        """Two points that keep their distance, and a force that is none."""
        problems = line_problems(self, self.i, self.j)
        if self.value == 0:
            problems.append(f"{label(self)} is 0 throughout; give a force in N.")
        return problems

    def shapes(self) -> tuple[shapes.Shape, ...]:
        """An actuator."""
        return (shapes.Spring(self.i, self.j, elastic=False, actuator=True),)
