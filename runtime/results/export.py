"""Results in files: .nc (netCDF 4), .zarr, .csv, .parquet, .mat and .html, whole or not at all.

The table of a .csv or .parquet file has one column a series, its unit in brackets.
"""

import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from codegen.errors import InputError, module_of_extra
from codegen.files.whole_files import require_replaceable, whole_file, whole_folder
from codegen.object_display import without_rounding
from codegen.readers.quantities import fitting_units
from runtime.results.dataset import dataset
from runtime.results.result import Result
from runtime.results.samples import FloatArray
from runtime.results.saved_result import GROUP, saved_result
from runtime.results.zarr_store import write_store

if TYPE_CHECKING:
    import pandas as pd

_LONGEST = 63  # layout: characters of a name in MATLAB (namelengthmax)
_KEYWORDS = {
    *("break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for"),
    *("function", "global", "if", "otherwise", "parfor", "persistent", "return", "spmd"),
    *("switch", "try", "while"),
}
_STORE = f"{GROUP}/zarr.json"  # the file that a store has which `save` wrote, and no other one


def check_place(path: Path) -> None:
    """Refuse a file that cannot be written, before any time is spent on its contents."""
    ending = path.suffix.lower()
    if path.is_dir() and ending != ".zarr":
        raise InputError(f"{path} is a folder; name a file in it, such as {path / 'run.nc'}.")
    if ending not in _FORMATS:
        raise InputError(
            f"{path}: a result is saved as {', '.join(_FORMATS)}, not as "
            f"{path.suffix or 'a file without ending'!r}. Change the ending."
        )
    if ending == ".zarr":
        require_replaceable(path, _STORE)
    folder = path.resolve().parent
    if not folder.is_dir():
        raise InputError(f"{path}: the folder {folder} does not exist. Create it.")
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"{path}: nothing can be written in the folder {folder} ({error.strerror}). "
            f"Choose another one."
        ) from error
    require_libraries(path, "writing", ", or save as .csv")


def require_libraries(path: Path, doing: str, otherwise: str = "") -> None:
    """Refuse a file whose format needs a library that is not installed."""
    ending = path.suffix.lower()
    _, libraries, extra = _FORMATS[ending]
    for library in libraries:
        needs = f"{path}: {doing} {ending} needs the library {library}"
        module_of_extra(library, extra, needs, otherwise)


def save(result: Result, path: Path) -> Path:
    """Write `result` by the ending of `path`; a file of that name is replaced at the end."""
    check_place(path)
    ending = path.suffix.lower()
    with whole_folder(path, _STORE) if ending == ".zarr" else whole_file(path) as temporary:
        _FORMATS[ending].write(result, temporary)
    return path


def columns(result: Result) -> Iterator[tuple[str, str, FloatArray]]:
    """The result as columns over time, (k,): name, unit (residuals have none) and values."""
    yield "time", "s", result.t
    series = result.description.series
    for row in (*series, *series.of_kind("residual")):
        known = row.kind != "work" or row.element in result.works
        if known and row.kind not in ("bookkeeping", "rate of state"):
            yield row.heading, row.unit, result.column(row)


def table(result: Result) -> dict[str, FloatArray]:
    """The columns by their headings, with the unit in brackets."""
    return {f"{name} [{unit}]" if unit else name: x for name, unit, x in columns(result)}


def frame(result: Result) -> "pd.DataFrame":
    """The columns with the time as index; their units are in the attributes."""
    import pandas as pd

    values = {name: x for name, _, x in columns(result)}
    found = pd.DataFrame(values, pd.Index(values.pop("time"), name="time"))
    found.attrs["units"] = {name: unit for name, unit, _ in columns(result)}
    return found


def short_table(result: Result, names: Sequence[str], count: int, unit: Any) -> "pd.DataFrame":
    """See `Result.table`."""
    import pandas as pd

    about, last = result.description, len(result.t) - 1
    names = names or [*(row.name for row in about.positions), *about.states.names]
    rows = np.unique(np.linspace(0, last, max(count, 2)).round().astype(int))[: last + 1]
    found = dict[str, list[float]]()
    shown = fitting_units({name: result.series(name)[1] for name in names}, unit)
    for name in names:
        x, of = result.series(name, shown[name])
        ends = [x.min(), x.max()] if len(x) else []
        found[f"{name} [{of}]"] = without_rounding([*x[rows], *ends])
    labels = [f"{t:.6g}" for t in result.t[rows]] + ["least", "greatest"][: 2 * len(rows)]
    return pd.DataFrame(found, pd.Index(labels, name="time [s]"))


def _write_csv(result: Result, path: Path) -> None:
    import pandas as pd

    with path.open("wb") as file:
        frame = pd.DataFrame(table(result), copy=False)
        frame.to_csv(file, index=False, na_rep="nan", lineterminator="\r\n")


def _write_parquet(result: Result, path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    written = pa.table(table(result)).replace_schema_metadata(result.about())
    with path.open("wb") as file:  # closed also where the disk is full
        pq.write_table(written, file)


def _write_netcdf(result: Result, path: Path) -> None:
    """Write the file's image: HDF's own writing keeps a file open where the disk is full."""
    import netCDF4
    from xarray.backends import NetCDF4DataStore

    file = netCDF4.Dataset(path.name, mode="w", format="NETCDF4", memory=1 << 16)
    dataset(result).dump_to_store(NetCDF4DataStore(file))  # type: ignore[no-untyped-call]
    content = saved_result(result)
    group = file.createGroup(GROUP)
    group.createDimension("byte", len(content))
    group.createVariable(GROUP, "u1", ("byte",))[:] = np.frombuffer(content, np.uint8)
    path.write_bytes(file.close())


def field_names(names: Iterable[str]) -> list[str]:
    """Names that MATLAB accepts, each another one, in order: ``a(bob.phi)`` is ``a_bob_phi``.

    MATLAB takes ASCII letters, digits and underscores, a letter first, 63 characters at most, and
    no keyword. Another letter becomes its number: ``φ`` is ``u03c6``.
    """
    taken = dict[str, None]()
    for name in names:
        letters = "".join(c if c.isascii() else f"u{ord(c):04x}" for c in name)
        plain = re.sub(r"[^A-Za-z0-9]+", "_", letters).strip("_")
        if not plain[:1].isalpha() or plain in _KEYWORDS:
            plain = f"x_{plain}"
        field, count = plain[:_LONGEST], 1
        while field in taken:
            count += 1
            tail = f"_{count}"
            field = f"{plain[: _LONGEST - len(tail)]}{tail}"
        taken[field] = None
    return list(taken)


def _matlab_struct(result: Result) -> dict[str, Any]:
    """The struct of a result: `series`, their `names` and `units`, `parameters`, and texts."""
    names, units, values = zip(*columns(result), strict=True)

    def struct(of: Mapping[str, Any]) -> dict[str, Any]:
        return dict(zip(field_names(of), of.values(), strict=True))

    return {
        "series": struct({name: x.reshape(-1, 1) for name, x in zip(names, values, strict=True)}),
        "names": struct({name: name for name in names}),
        "units": struct(dict(zip(names, units, strict=True))),
        "parameters": struct(result.parameters),
        "about": struct(result.about()),
    }


def _write_matlab(result: Result, path: Path) -> None:
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    struct = _matlab_struct(result)
    try:
        with path.open("wb") as file:
            savemat(file, {"result": struct}, long_field_names=True, do_compression=True)
    except MatWriteError as error:
        raise InputError(f"{path.name}: {error}. Save as .nc or .zarr.") from error


def _write_page(result: Result, path: Path) -> None:
    """A page for people: `runtime.show.html_report`."""
    from runtime.show.html_report import page

    path.write_text(page(result), encoding="utf-8")


class _Format(NamedTuple):
    """A format of files."""

    write: Callable[[Result, Path], None]
    libraries: tuple[str, ...] = ()  # that it needs, loaded before the time is spent on a run
    extra: str = "files"  # that brings them


_FORMATS = {
    ".nc": _Format(_write_netcdf, ("xarray", "netCDF4")),
    ".zarr": _Format(write_store, ("xarray", "zarr")),
    ".csv": _Format(_write_csv),
    ".parquet": _Format(_write_parquet, ("pyarrow", "pyarrow.parquet")),
    ".mat": _Format(_write_matlab, ("scipy.io",)),
    ".html": _Format(_write_page, ("bokeh",), "animation"),
}
