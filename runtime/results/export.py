"""Results in files: .nc (netCDF 4), .zarr, .csv, .parquet, .mat and .html, whole or not at all.

The table of a .csv or .parquet file has one column a series, its unit in brackets.
"""

import csv
import tempfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.files.whole_files import require_replaceable, whole_file, whole_folder
from runtime.results.dataset import dataset
from runtime.results.result import Result
from runtime.results.result_signature import signature
from runtime.results.saved_result import GROUP, saved_result

FloatArray = npt.NDArray[np.float64]

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
    extra = _FORMATS[ending].extra
    for library in _FORMATS[ending].libraries:
        try:
            import_module(library)
        except ImportError as error:
            raise InputError(
                f"{path}: writing {ending} needs the library {library}, which cannot be "
                f"imported ({error}). Run pip install 'linkwright[{extra}]', in the checkout "
                f"pip install '.[{extra}]', or save as .csv."
            ) from error


def save(result: Result, path: Path) -> Path:
    """Write `result` by the ending of `path`; a file of that name is replaced at the end."""
    check_place(path)
    ending = path.suffix.lower()
    with whole_folder(path, _STORE) if ending == ".zarr" else whole_file(path) as temporary:
        _FORMATS[ending].write(result, temporary)
    return path


_HEADINGS = {"power": "power({})", "nonconservative power": "nonconservative power({})"}
"""Kind of a series → its name in the heading of a column, where that is not its own."""


def columns(result: Result) -> dict[str, FloatArray]:
    """The result as columns over time, named `series [unit]`."""
    samples, table = result.samples, {"time [s]": result.t}
    for row in result.description.series:
        known = row.kind != "work" or row.element in result.works
        if known and row.kind not in ("bookkeeping", "rate of state", "energy"):
            name = _HEADINGS.get(row.kind, "{}").format(row.name)
            table[f"{name} [{row.unit}]"] = result.column(row)
    if result.description.has_masses:  # not a number where the scene leaves them out
        table["kinetic energy [J]"] = samples.energy[:, 0]
        table["potential energy [J]"] = samples.energy[:, 1]
    table["constraint residual"] = samples.residual[:, 0]
    table["velocity residual"] = samples.residual[:, 1]
    return table


def _write_csv(result: Result, path: Path) -> None:
    table = columns(result)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        writer.writerows(np.column_stack(list(table.values())).tolist())


def _write_parquet(result: Result, path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table(columns(result)).replace_schema_metadata(result.about())
    with path.open("wb") as file:  # closed also where the disk is full
        pq.write_table(table, file)


def _write_netcdf(result: Result, path: Path) -> None:
    """Write the file's image: HDF's own writing keeps a file open where the disk is full."""
    import netCDF4
    from xarray.backends import NetCDF4DataStore

    file = netCDF4.Dataset(path.name, mode="w", format="NETCDF4", memory=1 << 16)
    dataset(result).dump_to_store(NetCDF4DataStore(file))  # type: ignore[no-untyped-call]
    content = saved_result(result)
    group = file.createGroup(GROUP)
    group.signature = signature(content)
    group.createDimension("byte", len(content))
    group.createVariable(GROUP, "u1", ("byte",))[:] = np.frombuffer(content, np.uint8)
    path.write_bytes(file.close())


def _write_matlab(result: Result, path: Path) -> None:
    from runtime.results.matlab_file import write

    write(result, columns(result), path)


def _write_zarr(result: Result, path: Path) -> None:
    from runtime.results.zarr_store import write

    write(result, path)


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
    ".zarr": _Format(_write_zarr, ("xarray", "zarr")),
    ".csv": _Format(_write_csv),
    ".parquet": _Format(_write_parquet, ("pyarrow", "pyarrow.parquet")),
    ".mat": _Format(_write_matlab, ("scipy.io",)),
    ".html": _Format(_write_page, ("bokeh",), "animation"),
}
