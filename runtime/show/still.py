"""Figures of a machine at one instant: of a state, or of a result."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.drawing.figure import figure
from codegen.drawing.outlines import complete_picture
from codegen.drawing.shapes import Reaction
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.picture import geometry
from runtime.mechanism.sibling_scenes import sibling_named
from runtime.show.pictures import pictures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from runtime.results.assembled_state import Assembly, State
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]
COMPONENTS = ("fx", "fy", "torque")


def draw_state(
    mechanism: Mechanism, state: "State | Assembly", p: FloatArray, **drawing: Any
) -> "Figure":
    """Draw a mechanism at a state, with the joints of the scene that acts there."""
    known = sibling_named(mechanism, getattr(state, "scene", "")) or mechanism
    at, q, v = np.array([state.t]), state.q[None, :], state.v[None, :]
    found = geometry(known, p, at, q, v)
    picture = complete_picture(found.layout.picture(found.numbers[0], found.curves))
    return figure(picture, **drawing)


def draw_result(result: "Result", t: float | None, **drawing: Any) -> "Figure":
    """Draw a result at an instant, with the reactions there if forces are wanted."""
    one = result if t is None else result.at(t)
    drawn = pictures(one)
    names = {row.name for row in one.description.reactions}
    joints = {s.element for s in drawn.picture.symbols if isinstance(s.shape, Reaction)}
    reactions: Any = {
        joint: tuple(float(one.reaction(joint, word)[0]) for word in COMPONENTS)
        for joint in joints
        if {f"{joint}.{word}" for word in COMPONENTS} <= names
    }
    motion = pictures(result).poses
    return figure(drawn.picture, **drawing, reactions=reactions, motion=motion)
