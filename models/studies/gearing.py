"""Gears, racks and sliders drawn in their plane, with teeth that mesh as the bodies do."""

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes

from models.studies.mechanism import BAR
from models.studies.paths import ComplexArray, FloatArray

# Along the pitch, from the middle of a tooth: where a flank begins and ends, and the tip between.
FLANK = np.array([-0.36, -0.14, 0.14, 0.36])
BODY = "#dfe2e5"
ROOT, TIP = -1.2, 1.0  # depth and height of a tooth over the pitch line, in modules


def gear(
    axes: Axes, centre: complex, radius: float, teeth: int, angle: float, faint: bool = False
) -> None:
    """A gear of a pitch radius, a tooth in the direction `angle`, and a spoke there."""
    module = 2 * radius / teeth
    fill(axes, centre + _toothed(radius, teeth, angle, (ROOT * module, TIP * module)), faint)
    spoke = centre + np.exp(1j * angle) * np.array([0.15, 0.75]) * radius
    axes.plot(spoke.real, spoke.imag, color=BAR, linewidth=1.2, alpha=0.4 if faint else 1, zorder=3)
    circle(axes, centre, radius)


def ring(axes: Axes, centre: complex, radius: float, teeth: int, angle: float) -> None:
    """An internal gear: a gap, where the planet has its tooth, in the direction `angle`."""
    module = 2 * radius / teeth
    phase = angle + np.pi / teeth
    inner = _toothed(radius, teeth, phase, (-ROOT * module, -TIP * module))
    around = np.exp(1j * np.linspace(0, 2 * np.pi, 361)) * (radius + 4 * module)
    whole = centre + np.concatenate([around, inner[::-1]])
    axes.fill(whole.real, whole.imag, facecolor=BODY, edgecolor="none", zorder=2)
    for line in (inner, around):
        edge = centre + line
        axes.plot(edge.real, edge.imag, color=BAR, linewidth=0.8, zorder=2.2)
    circle(axes, centre, radius)


def rack(
    axes: Axes, middle: complex, half: float, module: float, angle: float, faint: bool = False
) -> None:
    """A rack with its teeth on the left of its direction and a gap over its middle."""
    pitch = np.pi * module
    count = int(half / pitch - 0.5)
    places = (np.arange(-count - 1, count + 1) + 0.5)[:, None] + FLANK
    heights = np.broadcast_to([ROOT, TIP, TIP, ROOT], places.shape) * module
    top = np.concatenate(
        [[half + 1j * ROOT * module], (places * pitch + 1j * heights).ravel()[::-1]]
    )
    ends = [-half + 1j * ROOT * module, -half - 4j * module, half - 4j * module]
    fill(axes, middle + np.exp(1j * angle) * np.concatenate([top, ends]), faint)


def block(axes: Axes, centre: complex, width: float, height: float) -> None:
    """A slider, upright."""
    corners = np.array([1 + 1j, -1 + 1j, -1 - 1j, 1 - 1j]) / 2
    fill(axes, centre + corners.real * width + 1j * corners.imag * height)


def circle(axes: Axes, centre: complex, radius: float) -> None:
    """A pitch circle."""
    line = centre + radius * np.exp(1j * np.linspace(0, 2 * np.pi, 181))
    axes.plot(line.real, line.imag, "-.", color=BAR, linewidth=0.5, zorder=2.3)


def fill(axes: Axes, outline: Iterable[complex], faint: bool = False) -> None:
    """A body as its filled outline; faint ones show where it has been."""
    line = np.array(list(outline), dtype=np.complex128)
    axes.fill(
        line.real, line.imag, facecolor="none" if faint else BODY,
        edgecolor="#b9bfc5" if faint else BAR, linewidth=0.6 if faint else 0.8,
        zorder=1.5 if faint else 2,
    )  # fmt: skip


def _toothed(radius: float, teeth: int, angle: float, heights: tuple[float, float]) -> ComplexArray:
    """The outline of a toothed circle about 0; heights of roots and tips over its pitch line."""
    root, tip = heights
    places: FloatArray = angle + (np.arange(teeth)[:, None] + FLANK) * 2 * np.pi / teeth
    radii = radius + np.broadcast_to([root, tip, tip, root], places.shape)
    line = (radii * np.exp(1j * places)).ravel()
    return np.append(line, line[0])
