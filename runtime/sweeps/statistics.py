"""Evaluation of a study: statistics, sensitivity indices by SALib, sentences and pictures."""

import warnings
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import InputError
from codegen.object_display import counted
from codegen.presentation import finish_axes, new_figure
from codegen.readers.values import one_line
from runtime.core.outcomes import Outcome
from runtime.sweeps.design import SALTELLI, salib, salib_problem
from runtime.sweeps.request import FAILED_TO_RUN, OK

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from runtime.sweeps.study import Study


_SHARES = (0.00135, 0.5, 0.99865)  # layout: three standard deviations of a normal distribution
_SHOWN = 3  # layout: failed runs of one outcome that sentences name
_LONGEST = 160  # layout: characters of a message in a sentence
_LEAST = 100  # accuracy: least number of runs for a useful delta


def statistics_of(study: "Study", shares: Sequence[float]) -> "pd.DataFrame":
    """One row a quantity; see `Study.statistics`."""
    import pandas as pd

    wrong = [share for share in shares if not 0.0 <= share <= 1.0]
    if wrong:
        raise InputError(f"A share is {wrong[0]:g}; it must lie from 0 to 1.")
    rows = []
    for name in study.quantities:
        values = study.data[name].values
        known = values[np.isfinite(values)]
        row = {"unit": study.unit(name), "runs": len(known)}
        if len(known):
            row |= {"mean": known.mean(), "sd": known.std(ddof=1) if len(known) > 1 else np.nan}
            row |= {"min": known.min(), "max": known.max()}
            row |= {f"{share:g}": np.quantile(known, share) for share in shares or _SHARES}
        rows.append(row)
    return pd.DataFrame(rows, index=pd.Index(study.quantities, name="quantity"))


def indices_of(study: "Study", quantity: str, seed: int) -> "pd.DataFrame":
    """Indices of a quantity, one row a factor; see `Study.sensitivity`."""
    import pandas as pd

    design, problem = study.facts()["design"], salib_problem(study.factors)
    values = study.data[quantity].values
    known = np.isfinite(values)
    if design["axes"]:
        raise InputError(
            "Indices are means over a distribution, and the design is a grid. Sweep with "
            "--sample saltelli (Sobol's indices), or lhs (delta)."
        )
    if design["kind"] == SALTELLI:
        if not known.all():
            raise InputError(
                f"{counted(int((~known).sum()), 'run')} of {len(values)} have no {quantity}, and "
                "Sobol's indices need them all: leave out of the intervals what makes no machine, "
                "or take a sample lhs, of which runs may be missing."
            )
        found = _analyzed("sobol", problem, values, seed=seed, calc_second_order=False)
        names = ("S1", "S1_conf", "ST", "ST_conf")
    else:
        if known.sum() < _LEAST:
            raise InputError(
                f"{counted(int(known.sum()), 'run')} have {quantity}; indices take at least "
                f"{_LEAST}."
            )
        points = np.stack([study.data[name].values[known] for name in study.factors], axis=1)
        found = _analyzed("delta", problem, points, values[known], seed=seed)
        if "delta" not in found:  # from SALib 1.6 on, by the way of its estimate
            found |= {"delta": found["delta_raw"], "delta_conf": found["delta_raw_conf"]}
        names = ("delta", "delta_conf", "S1", "S1_conf")
    table = {name: np.asarray(found[name], dtype=float) for name in names}
    return pd.DataFrame(table, index=pd.Index(study.factors, name="factor"))


def _analyzed(method: str, *data: Any, seed: int, **words: Any) -> dict[str, Any]:
    """The answer of an analysis of SALib, without its notices."""
    analyze, usual = salib(f"analyze.{method}").analyze, warnings.formatwarning
    try:
        with warnings.catch_warnings(record=True):  # SALib has a filter of its own
            found = analyze(*data, **words, seed=seed + 1, print_to_console=False)  # 0 is no seed
    finally:
        warnings.formatwarning = usual  # which SALib changes
    return dict(found)


def sentences_of(study: "Study", note: str) -> Iterator[str]:
    """Outcomes, extremes of the quantities, the first failures, and a note on the execution."""
    known = FAILED_TO_RUN | {one.name: one.meaning for one in Outcome}
    for outcome, count in study.outcomes.items():
        meaning = known.get(outcome, "not run yet").rstrip(".")
        yield f"{outcome}: {counted(count, 'run')} ({meaning[:1].lower() + meaning[1:]})"
        if outcome == OK or outcome not in known:
            continue
        for run in np.flatnonzero(study.data["outcome"].values == outcome)[:_SHOWN].tolist():
            point = ", ".join(f"{name} = {value:g}" for name, value in study.point(run).items())
            yield f"  run {run}, {point}: {one_line(study.data['message'].values[run], _LONGEST)}"
    for name in study.quantities:
        values = study.data[name].values
        if not np.isfinite(values).any():
            continue
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        text = f"{name}: from {values[low]:.6g} (run {low}) to {values[high]:.6g}"
        yield f"{text} {study.unit(name)}".rstrip() + f" (run {high})"
    if note:
        yield note
    if not study.complete:
        yield "Stopped before the end. Go on with the same request and --resume (resume=True)."


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
    return f"{name} ({study.unit(name)})" if study.unit(name) else name


def _curve(axes: "Axes", study: "Study", quantity: str) -> None:
    (name,) = study.factors
    x, y = study.data[name].values, study.data[quantity].values
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
    x, y, z = (study.data[name].values for name in (first, second, quantity))
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
    table = np.stack([study.data[name].values for name in names], axis=1)
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
