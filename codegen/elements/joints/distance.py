"""Distance constraint: two points keep their distance (Haug, sections 3.2 and 3.3)."""

from codegen.elements.joints.revolute_revolute import RevoluteRevolute
from codegen.elements.registry import element


@element
class Distance(RevoluteRevolute):
    """(r_j^P - r_i^P)ᵀ (r_j^P - r_i^P) - c² = 0; absolute where one of the points is on the ground.

    The equation is that of a massless link of length c, and so is the reaction: its x axis points
    from point i to point j.
    """

    kind = "distance"
    example = 'model.distance("wire", P, Q, 2.0)'
