"""Pictures of a study: a curve over one factor, a map over two, parallel axes of more."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.presentation import finish_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from runtime.sweeps.study import Study

FloatArray = npt.NDArray[np.float64]
MAP = "viridis"
_MOST_LINES = 2000  # layout: runs that parallel axes draw, at equal distances of all
FAILED = "#b23a48"


def figure(study: "Study", quantity: str) -> "Figure":
    """The quantity over the factors; runs without it are crosses."""
    values = study.data[quantity].values
    if not np.isfinite(values).any():
        raise InputError(f"No run has {quantity}, so there is nothing to draw.")
    count = len(study.factors)
    drawn = new_figure("picture", 7.0 if count < 3 else 1.6 * (count + 3), 4.4, dpi=130)
    axes = drawn.subplots()
    if count == 1:
        _curve(axes, study, quantity)
    elif count == 2:
        _map(axes, study, quantity)
    else:
        _parallel(axes, study, quantity)
    axes.set_title(f"{study.facts()['facts']['model']}, {len(study)} runs", loc="left", fontsize=10)
    return drawn


def _label(study: "Study", name: str) -> str:
    unit = study.data[name].attrs.get("units", "")
    return f"{name} ({unit})" if unit else name


def _columns(study: "Study", *names: str) -> tuple[FloatArray, ...]:
    return tuple(np.asarray(study.data[name].values, dtype=float) for name in names)


def _curve(axes: "Axes", study: "Study", quantity: str) -> None:
    (name,) = study.factors
    x, y = _columns(study, name, quantity)
    order = np.argsort(x)
    sampled = not study.facts()["design"]["axes"]
    axes.plot(x[order], y[order], "." if sampled else ".-", color="#1f6fb2", markersize=4)
    missing = x[~np.isfinite(y)]
    if len(missing):
        low = np.full(len(missing), np.nanmin(y))
        axes.plot(missing, low, "x", color=FAILED, label="failed")
        axes.legend(frameon=False)
    axes.set(xlabel=_label(study, name), ylabel=_label(study, quantity))
    finish_axes(axes, alpha=0.3)


def _map(axes: "Axes", study: "Study", quantity: str) -> None:
    first, second = study.factors
    x, y, z = _columns(study, first, second, quantity)
    missing = ~np.isfinite(z)
    shown: Any
    if study.facts()["design"]["axes"]:
        grid = study.grid[quantity]
        shown = axes.pcolormesh(
            grid[first].values, grid[second].values, grid.values.T, cmap=MAP, shading="nearest"
        )
    else:
        shown = axes.scatter(x[~missing], y[~missing], c=z[~missing], cmap=MAP, s=9)
    if missing.any():
        axes.plot(x[missing], y[missing], "x", color=FAILED, label="failed", markersize=4)
        axes.legend(frameon=False, loc="upper right")
    colours = axes.figure.colorbar(shown, ax=axes)
    colours.set_label(_label(study, quantity))
    axes.set(xlabel=_label(study, first), ylabel=_label(study, second))


def _parallel(axes: "Axes", study: "Study", quantity: str) -> None:
    from matplotlib.collections import LineCollection

    names = (*study.factors, quantity)
    table = np.stack(_columns(study, *names), axis=1)
    table = table[np.isfinite(table[:, -1])]
    step = -(-len(table) // _MOST_LINES)
    table = table[::step]
    low, high = table.min(axis=0), table.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    scaled = (table - low) / span
    places = np.arange(len(names), dtype=float)
    order = np.argsort(scaled[:, -1])  # the largest are drawn last
    lines = [np.column_stack([places, row]) for row in scaled[order]]
    shown = LineCollection(lines, cmap=MAP, linewidths=0.8, alpha=0.6)
    shown.set_array(table[order, -1])
    axes.add_collection(shown)
    for place, (bottom, top) in enumerate(zip(low, high, strict=True)):
        axes.axvline(place, color="#59636e", linewidth=0.8)
        axes.text(place, -0.03, f"{bottom:.4g}", ha="center", va="top", fontsize=8)
        axes.text(place, 1.02, f"{top:.4g}", ha="center", va="bottom", fontsize=8)
    axes.set(xlim=(-0.2, len(names) - 0.8), ylim=(-0.12, 1.12), yticks=[])
    axes.set_xticks(places, [_label(study, name) for name in names], fontsize=8)
    axes.spines[:].set_visible(False)
    axes.figure.colorbar(shown, ax=axes).set_label(_label(study, quantity))
