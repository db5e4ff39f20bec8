"""Figures of a machine at one instant: of a state, or of a result."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.matplotlib_painter import figure
from runtime.mechanism.companion_modules import geometry
from runtime.mechanism.mechanism import Mechanism, sibling_named
from runtime.show.moving_picture import moving_picture, moving_picture_of_part

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
    drawn = moving_picture(result) if t is None else moving_picture_of_part(result, one)
    first = {name: values[:1] for name, values in exerted(one).items()}
    return figure(drawn.picture, **drawing, series=first, motion=drawn.motion)


def exerted(result: "Result") -> dict[str, FloatArray]:
    """What joints, drivers and forces exert, by the names of the series, (k,) each, N or N m."""
    rows = result.description.reactions
    return {row.name: result.samples.reaction[:, k] for k, row in enumerate(rows)}
