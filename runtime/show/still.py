"""Figures of a machine at one instant: of a state, or of a result."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.drawing.figure import figure
from codegen.drawing.force_arrows import Reactions
from codegen.drawing.outlines import complete_picture
from codegen.drawing.picture import Picture
from codegen.drawing.shapes import ContactSide, Drive, Reaction
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.picture import geometry
from runtime.mechanism.sibling_scenes import sibling_named
from runtime.show.pictures import pictures, pictures_of_part

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from runtime.results.assembled_state import Assembly, State
    from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]


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
    drawn = pictures(result) if t is None else pictures_of_part(result, one)
    return figure(
        drawn.picture, **drawing, reactions=_reactions(one, drawn.picture), motion=drawn.motion
    )


def _reactions(one: "Result", picture: Picture) -> Reactions:
    """What joints, drivers and contacts exert at the first instant, as far as the scene has it."""
    rows = {row.name: k for k, row in enumerate(one.description.reactions)}
    found = {}
    for symbol in picture.symbols:
        if isinstance(symbol.shape, Reaction | Drive):
            first = "force" if isinstance(symbol.shape, Drive) else "fx"
            names = [f"{symbol.element}.{word}" for word in (first, "fy", "torque")]
            if any(name in rows for name in names):
                values = [
                    float(one.samples.reaction[0, rows[name]]) if name in rows else 0.0
                    for name in names
                ]
                found[symbol.element] = (values[0], values[1], values[2])
        elif isinstance(symbol.shape, ContactSide):
            name = f"{symbol.element}.{symbol.shape.force}"
            if name in rows:
                found[name] = (float(one.samples.reaction[0, rows[name]]), 0.0, 0.0)
    return found
