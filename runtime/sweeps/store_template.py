"""The template of a sweep's store: all its arrays, empty but for the points.

It is written in a folder of another name, which takes its place when it is whole.
"""

import json
import os
import shutil
import tempfile
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError
from runtime.results.zarr_store import MOST_METADATA
from runtime.sweeps.column_names import DONE, LAST, MESSAGE, OUTCOME, RUN, TIME, stored_name
from runtime.sweeps.design import Design
from runtime.sweeps.request import Request, digest_of
from runtime.sweeps.store import Group, require_zarr
from runtime.sweeps.store_attributes import ATTRIBUTES, FORMAT, Layout

_POINTS = 1 << 17  # layout: values of a factor in one chunk, of which a task reads those it needs


class Columns(NamedTuple):
    """Units of all that is stored, by name."""

    factors: Mapping[str, str]
    quantities: Mapping[str, str]
    series: Mapping[str, str]


def create_store(
    path: Path, request: Request, design: Design, columns: Columns, block: int, seconds: float
) -> None:
    """Write the template of a sweep, whole or not at all.

    A block has so many runs, each of so many seconds.
    """
    zarr, layout = require_zarr(), Layout(len(design.points), block)
    facts = request.facts(design.digest)
    about = {
        "format": FORMAT, "identity": uuid.uuid4().hex, "digest": digest_of(facts),
        "facts": facts, "design": design.facts,
        "quantities": [name for name, _ in request.quantities], "series": [*request.keep],
        "runs": layout.runs, "block": block, "seconds": seconds,
    }  # fmt: skip
    size = len(json.dumps(about))
    if size > MOST_METADATA // 2:
        raise InputError(
            f"The request takes {size} bytes as JSON, and a store has {MOST_METADATA // 2} for it. "
            "Give fewer names, parameters or options."
        )
    folder = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=path.parent))
    try:
        where = folder / "store"
        group = zarr.create_group(
            where, zarr_format=3,
            attributes={ATTRIBUTES: about, "coordinates": " ".join([*design.names, TIME])},
        )  # fmt: skip
        _create_arrays(group, request, design, columns, layout)
        _flush(where)
        try:
            where.rename(path)
        except OSError:
            raise InputError(f"{path} exists by now: another program has written it.") from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _flush(folder: Path) -> None:
    """Have all files of a folder on the disk, before a name that leads to them is."""
    for file in folder.rglob("*"):
        if file.is_file():
            with file.open("rb") as written:
                os.fsync(written.fileno())


def _create_arrays(
    group: Group, request: Request, design: Design, columns: Columns, layout: Layout
) -> None:
    runs, block, count = layout.runs, min(layout.block, layout.runs), request.points

    def create(
        name: str, kind: Any, fill: Any, chunks: Sequence[int], dims: Sequence[str], unit: str = "",
        shape: Sequence[int] | None = None, **attributes: str,
    ) -> Any:  # fmt: skip
        labels = {**({"units": unit} if unit else {}), **attributes}
        return group.create_array(
            stored_name(name), shape=tuple(shape or (runs,)), dtype=kind, fill_value=fill,
            chunks=tuple(chunks), dimension_names=tuple(dims), attributes=labels,
        )  # fmt: skip

    for k, name in enumerate(design.names):
        chunk = min(runs, _POINTS)
        values = create(name, "float64", np.nan, (chunk,), (RUN,), columns.factors[name])
        values[:] = design.points[:, k]
    for name, given in request.quantities:
        text = given if isinstance(given, str) else name
        create(name, "float64", np.nan, (block,), (RUN,), columns.quantities[name], quantity=text)
    create(OUTCOME, str, "", (block,), (RUN,))
    create(MESSAGE, str, "", (block,), (RUN,))
    create(LAST, "float64", np.nan, (block,), (RUN,), "s")
    if request.keep:
        instants = np.linspace(request.t_start, request.t_end, count)
        create(TIME, "float64", np.nan, (count,), (TIME,), "s", (count,))[:] = instants
    for name in request.keep:
        create(
            name, "float64", np.nan, (block, count), (RUN, TIME), columns.series[name],
            (runs, count),
        )  # fmt: skip
    create(DONE, "uint64", 0, (1,), ("block",), shape=(layout.blocks,))
