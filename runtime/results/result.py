"""The result of an analysis: series over time, how the run went, and how it ended."""

import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from runtime.results.time_series import TimeSeries

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Result(TimeSeries):
    """Motion of a machine at the instants `t`.

    Attributes
    ----------
    samples
        The arrays, one row an instant.
    outcome
        How the analysis ended; `message` says it in full, with time and joint.
    stats
        Counts of steps, evaluations and iterations, and the wall time in s.
    events
        Changes of modes, impacts and singular configurations between the instants.
    partitions
        The independent coordinates of a simulation: the first choice, then every change.
    works
        Work of effects and drivers since the start in J, by name, each (k,).
    not_unique
        Joints and drivers whose reactions redundant constraints leave open; those of least norm are
        given.
    singular
        The singular configurations that the run met, in order.
    accuracy
        Of a simulation with an accuracy target: the accuracy reached, and how it was estimated.
    parameters
        Parameter values by name.
    """

    @cached_property
    def data(self) -> "xr.Dataset":
        """All series as an `xarray.Dataset`, units in the attributes."""
        from runtime.results.dataset import dataset

        return dataset(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write to a file, whole or not at all.

        Parameters
        ----------
        path
            Ending in .nc (netCDF 4), .csv, .parquet or .html; a file of that name is replaced.

        Returns
        -------
        Path

        Raises
        ------
        InputError
            If the ending is another one, the folder does not exist or cannot be written, or a
            library for the format is not installed.
        """
        from runtime.results.files import save

        return save(self, Path(path))

    def plot(self, *names: str) -> "Figure":
        """Draw series over time, those of one unit in one panel.

        Parameters
        ----------
        names
            As in `series`; without any, the coordinates that are angles.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If there is no such series, or matplotlib is not installed.
        """
        from runtime.show.plot import plot

        return plot(self, names)

    def __repr__(self) -> str:
        """Title, span and outcome for a person."""
        count = len(self.t)
        ends = f" to {self.t[-1]:g}" if count > 1 else ""
        span = f"t = {self.t[0]:g}{ends} s" if count else "nothing computed"
        return (
            f"{self.description.title}, {self.analysis}: "
            f"{count} instant{'' if count == 1 else 's'}, {span}\n"
            f"  {self.outcome.name}: {self.message}"
        )
