"""A study: the runs of a sweep as labelled arrays, and each member again as a result."""

from collections import Counter
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError, UnknownNameError
from codegen.object_display import counted, html_of, html_table, listed
from codegen.readers.calls import checked_class, named_attributes
from codegen.readers.values import shown
from runtime.core.outcomes import Outcome
from runtime.mechanism.table_rows import unknown
from runtime.sweeps import column_names as columns
from runtime.sweeps import store
from runtime.sweeps.member_run import FAILED_TO_RUN, OK, run_member
from runtime.sweeps.request import Request

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from runtime.machine_facade import Machine
    from runtime.results.result import Result
    from runtime.sweeps.execution import Execution

NOT_RUN = "NOT RUN"  # outcome of a member whose block is not done


@named_attributes
@checked_class
class Study:
    """The runs of a sweep.

    Attributes
    ----------
    path
        The folder of the Zarr store.
    data
        An `xarray.Dataset` with the dimension `run`: factors as coordinates, quantities, `outcome`,
        `message` and `t_last` of each run, and the series that were kept over `t`.
    """

    def __init__(
        self, path: Path, machine: "Machine | None" = None, request: Request | None = None,
        execution: "Execution | None" = None,
    ) -> None:  # fmt: skip
        self.path, self._machine, self._request = path, machine, request
        self._execution = execution
        self._group = group = store.open_group(path)
        self._about = store.about_of(group)
        self.factors: tuple[str, ...] = tuple(self._about["design"]["names"])
        self.quantities: tuple[str, ...] = tuple(self._about["quantities"])
        self.series: tuple[str, ...] = tuple(self._about["series"])

    @cached_property
    def data(self) -> "xr.Dataset":
        """All runs as a dataset in memory, but for the kept series, which are read when used."""
        import xarray as xr

        written = store.runs_written(self._group)  # rows without a mark may be halves
        nothing = {columns.OUTCOME: "", columns.MESSAGE: ""}
        try:
            found: xr.Dataset = xr.open_zarr(
                self.path, consolidated=False, chunks=None, zarr_format=3
            ).drop_vars(columns.DONE)  # fmt: skip
            found = found.rename(
                {columns.stored_name(name): name for name in (*self.quantities, *self.series)}
            )
            for name in [str(name) for name in found.data_vars if name not in self.series]:
                column = found[name].load()
                if name not in self.factors:
                    column.values[~written] = nothing.get(name, np.nan)
                found = found.assign({name: column})
        except (OSError, ValueError, RuntimeError) as error:  # a file that is cut short
            raise InputError(
                f"{self.path} has rows that cannot be read ({type(error).__name__}: {error}). "
                "Repeat the sweep with --resume (resume=True), which makes them again."
            ) from error
        outcomes, messages = (found[name].values for name in (columns.OUTCOME, columns.MESSAGE))
        found[columns.OUTCOME] = columns.RUN, _outcomes(outcomes)
        found[columns.MESSAGE] = columns.RUN, messages.astype(object)
        found.attrs = {"model": self._about["facts"]["model"]}
        return found

    @property
    def grid(self) -> "xr.Dataset":
        """The runs of a grid with a dimension for each factor.

        Raises
        ------
        InputError
            If the design is no grid.
        """
        axes = self._about["design"]["axes"]
        if not axes:
            raise InputError(f"{self.path} is a sample of points and no grid; take data.")
        import xarray as xr

        names = self.factors
        shape = tuple(axes[name] for name in names)
        arrays = {}
        rows = (columns.OUTCOME, columns.MESSAGE, columns.LAST)
        for name in (*self.quantities, *rows, *self.series):
            column = self.data[name]
            rest = column.dims[1:]
            values = column.values.reshape(shape + column.shape[1:])
            arrays[name] = xr.Variable((*names, *rest), values, column.attrs)
        coordinates = {}
        for k, name in enumerate(names):
            first = tuple(slice(None) if k == j else 0 for j in range(len(names)))
            values = self.data[name].values.reshape(shape)[first]
            coordinates[name] = xr.Variable((name,), values, self.data[name].attrs)
        if self.series:
            coordinates[columns.TIME] = self.data[columns.TIME].variable
        return xr.Dataset(arrays, coordinates, self.data.attrs)

    @property
    def outcomes(self) -> dict[str, int]:
        """Outcome → number of runs."""
        return dict(Counter(self.data[columns.OUTCOME].values.tolist()).most_common())

    @property
    def complete(self) -> bool:
        """Whether all runs are made."""
        return NOT_RUN not in self.outcomes

    @property
    def failures(self) -> "xr.Dataset":
        """The runs that did not reach their end."""
        outcome = self.data[columns.OUTCOME].values
        return self.data.isel({columns.RUN: (outcome != OK) & (outcome != NOT_RUN)})

    def __len__(self) -> int:
        return int(self._about["runs"])

    def __getitem__(self, name: str) -> "xr.DataArray":
        """A column by its name: over the factors of a grid, else over the runs."""
        names = [str(one) for one in self.data.variables]
        if name not in names and f"end:{name}" in names:
            name = f"end:{name}"
        if name not in names:
            raise UnknownNameError(f"{self.path}: {unknown('column', name, names)}")
        return self.grid[name] if self._about["design"]["axes"] else self.data[name]

    def point(self, run: int) -> dict[str, float]:
        """The values of the factors of a run, by name, in their units."""
        k = self._index(run)
        return {name: float(self.data[name].values[k]) for name in self.factors}

    def member(self, run: int) -> "Result":
        """The result of one run, which is made again: by the same programs with the same bits.

        Parameters
        ----------
        run
            Its number, from 0; ``study.data`` has them in order.

        Raises
        ------
        InputError
            If there is no such run, or the study was loaded without its machine.
        LinkwrightError
            If the values of the run make no machine: what the study has as its message.
        """
        k = self._index(run)
        machine, request = self._machine, self._request
        if machine is None or request is None:
            raise InputError(
                f"{self.path} was loaded without its machine, and a file is data alone. Give it: "
                'load_study("study.zarr", machine=linkwright.load("model.py", "scene")).'
            )
        point = np.array([self.data[name].values[k] for name in request.names])
        return run_member(machine, request, point)

    def _index(self, run: Any) -> int:
        number = None if isinstance(run, bool) or not hasattr(run, "__index__") else int(run)
        if number is None or not -len(self) <= number < len(self):
            raise InputError(
                f"{self.path}: there is no run {shown(run)}; they have the numbers 0 to "
                f"{len(self) - 1}."
            )
        return number % len(self)

    def statistics(self, *shares: float) -> "pd.DataFrame":
        """Mean, standard deviation, extremes and quantiles of each quantity, over finite values.

        Parameters
        ----------
        shares
            Of the quantiles, from 0 to 1; 0.00135, 0.5 and 0.99865 (three standard deviations of a
            normal distribution) unless given.
        """
        from runtime.sweeps.statistics import statistics_of

        return statistics_of(self, shares)

    def sensitivity(self, quantity: str | None = None, seed: int = 0) -> "pd.DataFrame":
        """Indices that say how much of a quantity's variance each factor explains, by SALib.

        Of a design "saltelli" Sobol's indices of first order and in total, S1 and ST, each with its
        confidence interval of 95 %; of other samples the moment-independent delta and S1.

        Parameters
        ----------
        quantity
            Name of the quantity; the first one unless given.
        seed
            Of the resampling behind the confidence intervals.

        Raises
        ------
        InputError
            If the design is a grid, runs have failed whose numbers are needed, or SALib is missing.
        """
        from runtime.sweeps.sensitivity import indices_of

        return indices_of(self, self._quantity(quantity), seed)

    def plot(self, quantity: str | None = None) -> "Figure":
        """A quantity over the factors: a curve of one, a map of two, parallel axes of more.

        Parameters
        ----------
        quantity
            Name of the quantity; the first one unless given.
        """
        from runtime.sweeps.pictures import figure

        return figure(self, self._quantity(quantity))

    def _quantity(self, name: str | None) -> str:
        if name is None:
            return self.quantities[0]
        if name not in self.quantities and f"end:{name}" in self.quantities:
            return f"end:{name}"
        if name not in self.quantities:
            raise UnknownNameError(f"{self.path}: {unknown('quantity', name, self.quantities)}")
        return name

    def facts(self) -> dict[str, Any]:
        """The study as JSON: request, design, outcomes."""
        names = ("facts", "digest", "design", "runs", "block")
        return {
            "store": str(self.path), "complete": self.complete, "outcomes": self.outcomes,
            **{name: self._about[name] for name in names},
        }  # fmt: skip

    def sentences(self) -> tuple[str, ...]:
        """What became of the runs."""
        from runtime.sweeps.statistics import sentences_of

        return tuple(sentences_of(self, self._execution))

    def __repr__(self) -> str:
        """Model, design and outcomes."""
        return "\n  ".join((self._headline, *self.sentences()))

    def _repr_html_(self) -> str:
        """The same with a table of the quantities, for notebooks."""
        table = self.statistics()
        rows = (
            (name, *(x if isinstance(x, str) else float(x) for x in row))
            for name, row in zip(table.index, table.to_numpy(), strict=True)
        )
        text = "\n".join((self._headline, *self.sentences()))
        return html_of(text, html_table(("quantity", *table.columns), rows))

    @property
    def _headline(self) -> str:
        kind = self._about["design"]["kind"]
        return (
            f"{self._about['facts']['model']}: {counted(len(self), 'run')} ({kind}) over "
            f"{listed(self.factors)}, in {self.path}"
        )


def _outcomes(values: npt.NDArray[Any]) -> npt.NDArray[np.object_]:
    """Names of outcomes as Python's texts."""
    return np.array([str(name) or NOT_RUN for name in values], dtype=object)


def meaning_of(outcome: str) -> str:
    """An outcome of a member in words."""
    if outcome in FAILED_TO_RUN:
        return FAILED_TO_RUN[outcome]
    return Outcome[outcome].meaning if outcome in Outcome.__members__ else "not run yet"
