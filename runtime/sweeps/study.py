"""A study: the runs of a sweep as labelled arrays, and each member again as a result."""

import os
import warnings
from collections import Counter
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.object_display import counted, html_of, html_table, listed
from codegen.presentation import in_pyplot
from codegen.readers import arguments as readers
from codegen.readers.calls import checked_class, named_attributes
from codegen.readers.values import KindError, shown
from runtime.machine_facade import Machine
from runtime.mechanism.table_rows import unknown
from runtime.results.dataset import require_dask
from runtime.sweeps.request import OK, Request, changed_programs, companion_texts, run_member
from runtime.sweeps.store import LAST, MESSAGE, OUTCOME, RUN, open_store, stored_name

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from runtime.results.result import Result

NOT_RUN = "NOT RUN"  # outcome of a member that is not made


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
        self, path: Path, machine: Machine | None = None, request: Request | None = None,
        note: str = "",
    ) -> None:  # fmt: skip
        self._store = open_store(path)
        self.path, self._machine, self._note = path, machine, note
        self._request = request or self._store.request
        self.factors: tuple[str, ...] = self._request.factors
        self.quantities: tuple[str, ...] = tuple(self._request.quantities)
        self.series: tuple[str, ...] = self._request.series

    @cached_property
    def data(self) -> "xr.Dataset":
        """All runs as a dataset in memory, but for the kept series, which are read when used."""
        require_dask()
        import xarray as xr

        try:
            outcomes = self._store.outcomes()  # first: a sweep writes them last
            found: xr.Dataset = xr.open_zarr(
                self.path, consolidated=False, chunks=None, zarr_format=3
            )
            found = found.rename(
                {stored_name(name): name for name in (*self.quantities, *self.series)}
            )
            read = found.drop_vars(self.series).load()
        except (OSError, ValueError, RuntimeError) as error:  # a file that is cut short
            raise InputError(
                f"{self.path} has rows that cannot be read ({type(error).__name__}: {error}). "
                "Repeat the sweep with --resume (resume=True), which makes them again."
            ) from error
        made = outcomes != ""  # other rows may be halves
        for name in (*self.quantities, LAST):
            read[name].values[~made] = np.nan
        messages = np.where(made, read[MESSAGE].values.astype(object), "")
        texts = {OUTCOME: np.where(made, outcomes, NOT_RUN), MESSAGE: messages}
        found = found.assign({**read.data_vars, **{k: (RUN, text) for k, text in texts.items()}})
        found.attrs = {"model": self._request.model}
        return found

    @property
    def grid(self) -> "xr.Dataset":
        """The runs of a grid with a dimension for each factor.

        Raises
        ------
        InputError
            If the design is no grid.
        """
        if not self._store.about.design.axes:
            raise InputError(f"{self.path} is a sample of points and no grid; take data.")
        import pandas as pd
        import xarray as xr

        values = [dict.fromkeys(self.data[name].values.tolist()) for name in self.factors]
        index = pd.MultiIndex.from_product(values, names=self.factors)
        runs = xr.Coordinates.from_pandas_multiindex(index, RUN)
        found = self.data.drop_vars(self.factors).assign_coords(runs).unstack(RUN)
        for name in self.factors:
            found[name].attrs = self.data[name].attrs
        by_name = zip(self.factors, map(list, values), strict=True)
        return found.sel(dict(by_name)).transpose(*self.factors, ...)  # pandas has sorted them

    @property
    def outcomes(self) -> dict[str, int]:
        """Outcome → number of runs."""
        return dict(Counter(self.data[OUTCOME].values.tolist()).most_common())

    @property
    def complete(self) -> bool:
        """Whether all runs are made."""
        return NOT_RUN not in self.outcomes

    @property
    def failures(self) -> "xr.Dataset":
        """The runs that did not reach their end."""
        outcome = self.data[OUTCOME].values
        return self.data.isel({RUN: (outcome != OK) & (outcome != NOT_RUN)})

    def __len__(self) -> int:
        return self._store.about.runs

    def __getitem__(self, name: str) -> "xr.DataArray":
        """A column by its name: over the factors of a grid, else over the runs."""
        name = self._column(name)
        return self.grid[name] if self._store.about.design.axes else self.data[name]

    def unit(self, name: str) -> str:
        """The unit of a factor or quantity, "" where it has none."""
        return str(self.data[self._column(name)].attrs.get("units", ""))

    def point(self, run: int) -> dict[str, float]:
        """The values of the factors of a run, by name, in their units."""
        k = self._index(run)
        return {name: float(self.data[name].values[k]) for name in self.factors}

    def member(self, run: int) -> "Result":
        """Repeat one run and return its result; the same programs return the same bits.

        Parameters
        ----------
        run
            The number of the run, from 0, in the order of ``study.data``.

        Raises
        ------
        InputError
            If there is no such run, or the study was loaded without its machine.
        LinkwrightError
            If the machine refuses the values of the run, with the run's message in the study.
        """
        k = self._index(run)
        if self._machine is None:
            raise InputError(
                f"{self.path} was loaded without its machine, and a file is data alone. Give it: "
                'load_study("study.zarr", machine=linkwright.load("model.py", "scene")).'
            )
        point = np.array([*self.point(k).values()])
        return run_member(self._machine, self._request, point)

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
        """SALib's sensitivity indices: the share of a quantity's variance that a factor explains.

        For the design "saltelli": Sobol's first-order and total indices S1 and ST, each with its
        confidence interval of 95 %. For other samples: the moment-independent delta and S1.

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
        from runtime.sweeps.statistics import indices_of

        return indices_of(self, self._quantity(quantity), seed)

    @in_pyplot()
    def plot(self, quantity: str | None = None) -> "Figure":
        """Plot a quantity over the factors: a curve for one, a map for two, parallel axes for more.

        Parameters
        ----------
        quantity
            Name of the quantity; the first one unless given.
        """
        from runtime.sweeps.statistics import figure

        return figure(self, self._quantity(quantity))

    def _column(self, name: str, names: Sequence[str] = (), kind: str = "column") -> str:
        names = names or [str(one) for one in self.data.variables]
        for found in (name, f"end:{name}"):
            if found in names:
                return found
        raise UnknownNameError(f"{self.path}: {unknown(kind, name, names)}")

    def _quantity(self, name: str | None) -> str:
        return self._column(name or self.quantities[0], self.quantities, "quantity")

    def facts(self) -> dict[str, Any]:
        """The study as JSON: request, design, outcomes."""
        about = self._store.about.model_dump(mode="json", include={"facts", "design", "runs"})
        return {
            "store": str(self.path), "complete": self.complete, "outcomes": self.outcomes, **about
        }  # fmt: skip

    def sentences(self) -> tuple[str, ...]:
        """The outcomes of the runs in sentences."""
        from runtime.sweeps.statistics import sentences_of

        return tuple(sentences_of(self, self._note))

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
        return (
            f"{self._request.model}: {counted(len(self), 'run')} ({self._store.about.design.kind}) "
            f"over {listed(self.factors)}, in {self.path}"
        )


def _study_path(value: Any) -> Path:
    path: Path = readers.path(value)
    if not path.is_dir():
        raise KindError("there is no such folder; name the one that a sweep has written.")
    return path


_MACHINE = readers.instance("runtime.", "Machine", "a machine, as load() makes it")


@readers.reads(path=_study_path, machine=readers.optional(_MACHINE))
def load_study(path: str | os.PathLike[str], machine: Machine | None = None) -> Study:
    """The study that a sweep wrote, in any process.

    A study is data only: nothing in it is executed, and no model that it names is loaded.

    Parameters
    ----------
    path
        The folder of the Zarr store.
    machine
        The machine of the study, for `Study.member`. A warning names programs that differ from
        those of the sweep, so that the last digits of a run may differ.

    Raises
    ------
    InputError
        If the folder was not written by a sweep, contains anything else, or belongs to another
        machine.
    """
    place = Path(path).resolve()
    study = Study(place)
    if machine is None:
        return study
    request, origin = study._request, machine.mechanism.origin
    if origin is None or origin.digest != request.generated_module:
        raise InputError(
            f"{place} is a study of {request.model} whose generated module had another text than "
            f"that of {machine.mechanism.title}: the model has changed since, or is another one."
        )
    controllers = request.options.get("controllers")
    if controllers:
        raise InputError(
            f"The runs of this study took functions ({', '.join(controllers)}), which no file "
            "keeps. Repeat the call of sweep with resume=True: it returns the study with them."
        )
    changes = changed_programs(study.facts()["facts"])
    if companion_texts(machine, [*request.companions]) != request.companions:
        changes.append("the derivatives or reduced equations have another text")
    if changes:
        warnings.warn(
            f"Runs of {place} that are made again may differ in their last digits: "
            f"{'; '.join(changes)}.",
            stacklevel=2,
        )
    return Study(place, machine)
