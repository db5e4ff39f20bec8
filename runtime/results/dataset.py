"""A result as an xarray.Dataset: its variables, each a group of series with labels."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import InputError
from runtime.mechanism.series_table import Series
from runtime.results.result import Result

if TYPE_CHECKING:
    import xarray as xr


class Variables:
    """The variables of a result, and their coordinates, as they are added."""

    def __init__(self, result: Result) -> None:
        self.result, self.data = result, dict[str, Any]()
        self.coords: dict[str, Any] = {"time": ("time", result.t, {"units": "s"})}

    def add(
        self, name: str, over: str, rows: Sequence[Series | None], long_name: str = "",
        unit: str | None = None, shape: tuple[int, ...] | None = None,
    ) -> None:  # fmt: skip
        """Add series over the time and the dimensions `over`; None is not a number.

        They have the `unit`, by default that which all of them share.
        """
        count, units = len(self.result.t), {row.unit for row in rows if row}
        nothing = np.full(count, np.nan)
        columns = [nothing if row is None else self.result.column(row) for row in rows]
        values = np.stack(columns, axis=1) if columns else np.zeros((count, 0))
        if unit is None:
            unit = units.pop() if len(units) == 1 else ""
        about = {"long_name": long_name, "units": unit}
        about = {word: text for word, text in about.items() if text}
        values = values.reshape(count, *(shape or (len(rows),)))
        self.data[name] = ("time", *over.split()), values, about

    def label(self, dimension: str, texts: Iterable[str], **of_each: Iterable[str]) -> None:
        """Add the labels along a dimension, and other texts of each of them."""
        # of type text also where there are none
        self.coords[dimension] = np.array([*texts], dtype=np.str_)
        for name, values in of_each.items():
            self.coords[name] = dimension, np.array([*values], dtype=np.str_)


def require_dask() -> None:
    """InputError if Dask is installed and does not import, as without /proc: xarray needs it."""
    try:
        import dask  # noqa: F401
    except ImportError:  # without which xarray does
        pass
    except Exception as error:  # of psutil's, of which it asks the number of processors
        raise InputError(
            f"xarray imports dask, which is installed and does not start here ({error}). Mount "
            "/proc, or uninstall dask."
        ) from error


def dataset(result: Result) -> "xr.Dataset":
    """Label the series of a result; reactions that a joint does not have are not a number."""
    require_dask()
    import xarray as xr

    found, description = Variables(result), result.description
    series, places = description.series, description.positions
    units = ("velocity", "unit", "velocity_unit", "acceleration_unit")
    of_each = {word: [getattr(row, word) for row in places] for word in units}
    found.label("coordinate", (row.name for row in places), **of_each)
    found.add("q", "coordinate", series.of_kind("coordinate"), "coordinates")
    found.add("v", "coordinate", series.of_kind("velocity"), "velocities")
    found.add("a", "coordinate", series.of_kind("acceleration"), "accelerations")
    if spins := series.of_kind("spin"):
        found.label("spin_component", _names(spins))
        found.add("spin", "spin_component", spins, "angular velocities in body axes")
        entries, bodies = series.of_kind("rotation"), [body for body, _ in description.turning]
        for dimension, labels in ("body", bodies), ("global_axis", "xyz"), ("body_axis", "xyz"):
            found.label(dimension, labels)
        shape = len(bodies), 3, 3
        found.add("rotation", "body global_axis body_axis", entries, "rotation", "1", shape)
    residual = np.array(result.samples.residual.T)
    about = {"long_name": "largest |Phi|, m or rad"}
    found.data["constraint_residual"] = "time", residual[0], about
    about = {"long_name": "largest |Phi_q v - nu|, m/s or rad/s"}
    found.data["velocity_residual"] = "time", residual[1], about
    if states := series.of_kind("state"):
        found.add("y", "state", states, "first-order states and sampled values")
        found.label("state", _names(states), state_unit=[row.unit for row in states])
    if description.has_masses:
        powers = series.of_kind("power")
        found.label("source", _names(powers))
        found.add("power", "source", powers, unit="W")
        if powers := series.of_kind("nonconservative power"):
            over, what = "nonconservative_source", "power of the forces without a potential"
            found.add("nonconservative_power", over, powers, what)
            found.label(over, _names(powers))
        if energies := series.of_kind("energy"):
            found.label("part", _names(energies))
            found.add("energy", "part", energies)
        _add_reactions(found, series.of_kind("reaction"))
    _add_effects(found, series.of_kind("effect"))
    if works := [row for row in series.of_kind("work") if row.element in result.works]:
        found.label("worker", [row.element for row in works])
        found.add("work", "worker", works)
    if points := description.tracked:
        found.label("place", points)
        axes = "xyz" if description.turning else "xy"
        found.label("axis", axes)
        for name, letter in ("point", ""), ("point_velocity", "v"), ("point_acceleration", "a"):
            rows = [series.get(f"{of}.{letter}{axis}") for of in points for axis in axes]
            if any(rows):
                found.add(name, "place axis", rows, shape=(len(points), len(axes)))
    if outputs := series.of_kind("expression"):
        found.label("output", _names(outputs), output_unit=[row.unit for row in outputs])
        found.add("expression", "output", outputs, "expressions, in output_unit", unit="")
    if modes := series.of_kind("mode"):
        kinds = [row.kind for row in description.switches]
        found.label("switch", _names(modes), switch_kind=kinds)
        holds = "1: condition holds, 0: not, 2: its function stays at zero"
        found.add("mode", "switch", modes, holds, unit="")
        share = "share of the force of mode 1 where mode is 2"
        found.add("share", "switch", series.of_kind("share"), share)
    return xr.Dataset(found.data, coords=found.coords, attrs=result.about())


def _names(rows: Iterable[Series]) -> list[str]:
    return [row.name for row in rows]


def _add_reactions(found: Variables, rows: Sequence[Series]) -> None:
    """The reactions over joint and component."""
    table = {(row.element, row.component): row for row in rows}
    joints = dict.fromkeys(row.element for row in rows)
    units = {row.component: row.unit for row in rows}
    found.label("joint", joints)
    found.label("component", units, component_unit=units.values())
    cells, shape = [table.get((a, b)) for a in joints for b in units], (len(joints), len(units))
    axes = "global" if found.result.description.turning else "joint"
    about = f"first body on second, in {axes} axes, in component_unit"
    found.add("reaction", "joint component", cells, about, unit="", shape=shape)


def _add_effects(found: Variables, rows: Sequence[Series]) -> None:
    """A variable for each quantity of effects, over time and effect; not a number of others."""
    of_quantity: dict[str, dict[str, Series]] = {}  # quantity → label → series
    for row in rows:
        label = f"{row.element}.{row.component}" if row.component else row.element
        of_quantity.setdefault(row.quantity or "component", {})[label] = row
    labels = dict.fromkeys(label for parts in of_quantity.values() for label in parts)
    if labels:
        found.label("effect", labels)
    for quantity, parts in of_quantity.items():
        found.add(quantity, "effect", [parts.get(label) for label in labels])
        if len({row.unit for row in parts.values()}) > 1:
            units = [parts[label].unit if label in parts else "" for label in labels]
            found.label("effect", labels, **{f"{quantity}_unit": units})
