"""Figures of states and results: the machine at an instant or in motion, and series over time."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.drawing.annotations import loads
from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.matplotlib_painter import figure
from codegen.drawing.picture import (
    BodyLayout,
    Layout,
    Picture,
    ShapeLayout,
    Symbol,
    constant_or_all,
)
from codegen.drawing.shapes import changed
from codegen.errors import InputError
from codegen.presentation import new_figure
from codegen.readers.quantities import fitting_units
from runtime.mechanism.mechanism import Mechanism, sibling_named
from runtime.mechanism.table_rows import TRACKED
from runtime.results.motion_at_instants import for_curves

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
    return figure(complete_picture(picture_at_states(known, p, at, q, v)).first, **drawing)


def picture_at_states(
    mechanism: Mechanism, p: FloatArray, t: FloatArray, q: FloatArray, v: FloatArray
) -> Picture:
    """The picture in motion at states, without outlines that follow from joints.

    Its companion module is built where it is missing. Parameters, (np,) or (k, np), may have the
    constants behind them; instants in s are (k,), coordinates and velocities (k, n).
    """
    module = mechanism.companion("picture")
    bodies = tuple(BodyLayout(*row) for row in module.BODIES)
    rows = tuple(ShapeLayout(*row) for row in module.SHAPES)
    layout = Layout(mechanism.title.replace("/", ", "), bodies, rows)
    numbers = np.zeros((len(t), layout.size))
    q, v = np.ascontiguousarray(q, dtype=float), np.ascontiguousarray(v, dtype=float)
    at_each = np.array(np.broadcast_to(p, (len(t), p.shape[-1])))
    for k in range(len(t)):
        module.picture(float(t[k]), q[k], v[k], at_each[k], numbers[k])

    def curves(alpha: float) -> FloatArray:
        points = np.zeros(2 * layout.curves)
        module.curves(alpha, at_each[0], points)
        return points

    return layout.picture(t, numbers, curves)


def draw_result(result: "Result", t: float | None, **drawing: Any) -> "Figure":
    """Draw a result at an instant, with all that acts there if forces are wanted."""
    one = result if t is None else result.at(t)
    picture = moving_picture(result, one).first
    if drawing.get("forces"):
        drawing["series"] = {name: now[0] for name, now in exerted(one, everything=True).items()}
        drawing["run"] = loads(moving_picture(result), exerted(result, everything=True))
    return figure(picture, **drawing)


def exerted(result: "Result", everything: bool = False) -> dict[str, FloatArray]:
    """Series → what is exerted, (k,), N or N m: of the scene's outputs, or `everything`."""
    found: dict[str, FloatArray] = {}
    named = [(slice(None), result.description, result.samples)]
    for rows, description, samples in result._afterwards if everything else named:
        for k, row in enumerate(description.reactions):
            found.setdefault(row.name, np.zeros(len(result.t)))[rows] = samples.reaction[:, k]
    return found


def moving_picture(result: "Result", part: "Result | None" = None) -> Picture:
    """The moving picture of a result at its instants, or at those of a part of it.

    A part has outlines, size and motion of the whole: a body keeps its outline where a joint that
    held it has been released, and guides their length.

    Raises InputError if the result has no instants, or comes from no machine that is known.
    """
    mechanism, title = result._mechanism, result.description.title
    if mechanism is None:
        raise InputError(f"{title}: the machine of this result is not known; load it and run it.")
    if not len(result.t):
        raise InputError(f"{title}: the result has no instants to draw ({result.message})")
    shown = _joined(result, mechanism)
    whole = complete_picture(replace(shown, motion=shown.poses))
    if part is None or part is result:
        return whole
    some = _joined(part, mechanism)
    return replace(some, bodies=whole.bodies, size=whole.size, motion=whole.motion)


def _joined(result: "Result", mechanism: Mechanism) -> Picture:
    """The picture of a result, of all its scenes one after the other."""
    t, spans = result.t, spans_of(result, mechanism)
    parts = [_of_span(result, known, rows) for known, rows in spans]
    if len(parts) == 1:
        return parts[0]
    acting: dict[tuple[str, str, int], list[tuple[slice, Symbol]]] = {}
    for (_, rows), part in zip(spans, parts, strict=True):
        seen = Counter[tuple[str, str]]()
        for symbol in part.symbols:
            pair = symbol.element, symbol.shape.kind
            seen[pair] += 1
            acting.setdefault((*pair, seen[pair]), []).append((rows, symbol))
    ends = [*t, np.nextafter(t[-1], np.inf)]
    symbols = []
    for found in acting.values():

        def over_time(*values: Any, found: Any = found) -> Any:
            """A number from those of the spans; elsewhere it is that of the first instant."""
            whole = np.full(len(t), np.ravel(values[0])[0])
            for (rows, _), value in zip(found, values, strict=True):
                whole[rows] = value
            return constant_or_all(whole)

        shape = changed(over_time, *(symbol.shape for _, symbol in found))
        times = tuple((float(ends[rows.start]), float(ends[rows.stop])) for rows, _ in found)
        always = len(times) == len(parts)
        symbols.append(replace(found[0][1], shape=shape, spans=() if always else times))
    poses = np.concatenate([part.poses for part in parts])
    return replace(parts[0], poses=poses, t=t, symbols=tuple(symbols))


def spans_of(result: "Result", mechanism: Mechanism) -> list[tuple[Mechanism, slice]]:
    """The scenes of the result one after the other, and the rows of their instants."""
    motion, t = result._motion, result.instants_of_states
    if motion is None or not mechanism.description.watched:
        return [(mechanism, slice(0, len(t)))]
    scenes = [motion.scene(float(instant)) for instant in t]
    bounds = [0, *(k for k in range(1, len(t)) if scenes[k] != scenes[k - 1]), len(t)]
    return [
        (sibling_named(mechanism, scenes[first]) or mechanism, slice(first, last))
        for first, last in pairwise(bounds)
    ]


def _of_span(result: "Result", mechanism: Mechanism, rows: slice) -> Picture:
    """The picture while one set of joints acts."""
    samples, here, there = result.samples, mechanism.description, result.description
    places = {name: k for k, name in enumerate(there.coordinates.names)}
    columns = [places[name] for name in here.coordinates.names]
    p = np.array([result.parameters.get(row.name, row.default) for row in here.parameters])
    p = np.tile(p, (len(samples.t[rows]), 1))
    for name in here.unknown:  # which exerts one of its components
        parts = [k for k, r in enumerate(here.reactions) if r.element == name and "N" in r.unit]
        p[:, here.parameters.index(name)] = samples.reaction[rows][:, parts].sum(axis=1)
    q, v = samples.q[rows][:, columns], samples.v[rows][:, columns]
    return picture_at_states(mechanism, p, samples.t[rows], q, v)


def plot(result: "Result", names: Sequence[str] = (), unit: str | Sequence[str] = ()) -> "Figure":
    """Draw series of a result (as in `Result.series`; or every angle), one panel for each unit.

    Each is drawn in the first `unit` that fits it, or in its own. Tracked points are drawn by their
    paths, y over x in equal axes, in a panel below; in space by x, y and z over time.
    """
    result = for_curves(result)
    rows, left_out = result.description.positions, result.description.left_out
    tracked = {*result.description.tracked, *(r.name for r in left_out if r.kind == TRACKED)}
    chosen = names or [r.name for r in rows if r.is_angle] or [r.name for r in rows]
    if result.description.turning:
        chosen = names or [*(r.name for r in rows if r.unit != "1"), *result.description.spins]
        axes_of = ([f"{n}.{c}" for c in "xyz"] if n in tracked else [n] for n in chosen)
        chosen, tracked = [name for parts in axes_of for name in parts], set()
    own = ("m" if str(n) in tracked else result.series(n)[1] for n in chosen)
    shown = fitting_units(dict(zip(chosen, own, strict=True)), unit)
    panels: dict[str, list[str]] = {}  # unit → names
    for name in chosen:
        if name not in tracked:
            panels.setdefault(shown[name], []).append(name)
    points, last = [name for name in chosen if name in tracked], len(panels) - 1
    heights = [2.4] * len(panels) + [5.0] * bool(points)
    drawn = new_figure("plot", 7.0, sum(heights))
    axes = drawn.subplots(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    for number, (axis, (label, members)) in enumerate(zip(axes, panels.items(), strict=False)):
        for name in members:
            axis.plot(result.t, result.series(name, label)[0], label=name)
        if number < last:
            axis.sharex(axes[last])
            axis.tick_params(labelbottom=False)
        axis.set(ylabel=label, xlabel="time (s)" if number == last else "")
    for name in points:
        axes[-1].plot(*result.point(name, unit=shown[name]).T, label=name)
        of = f"({shown[name]})"
        axes[-1].set(xlabel=f"x {of}", ylabel=f"y {of}", aspect="equal")
    for axis in axes:
        axis.legend(frameon=False)
        axis.grid(visible=True, alpha=0.3)
    axes[0].set_title(result.description.title, loc="left")
    return drawn
