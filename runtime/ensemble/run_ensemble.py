"""An ensemble: members read, runs made, rows labelled."""

from typing import TYPE_CHECKING, Any

from codegen.errors import InputError
from runtime.ensemble.dataset import Rows
from runtime.ensemble.member_arrays import LEFT
from runtime.ensemble.members import (
    Columns,
    FloatArray,
    forbidden_members,
    read_members,
    require_room,
)
from runtime.ensemble.single_runs import SingleRuns
from runtime.ensemble.threads import make_runs
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.progress_bar import Progress

if TYPE_CHECKING:
    import xarray as xr


def run_ensemble(
    mechanism: Mechanism, t_end: float, times: FloatArray, parameters: Columns | None,
    starts: Columns | None, threads: int, max_bytes: int, progress: Progress, **options: Any,
) -> "xr.Dataset":  # fmt: skip
    """One row a member; see `Machine.ensemble`. `options` are those of `simulate`."""
    members = read_members(mechanism, parameters, starts)
    if any(row.reconnects for row in mechanism.description.watched):
        raise InputError(
            f"{mechanism.title}: ensemble: joints come and go in this scene, and its runs do not "
            "have the same variables. Use a sweep."
        )
    require_room(mechanism, members.count, len(times), max_bytes)
    rows = Rows(members, times)
    rows.status[forbidden_members(mechanism, members)] = LEFT  # to a single run, which says why
    single = SingleRuns(mechanism, t_end, members, rows, options)
    made = None
    try:
        first, made = single.prepare()
        make_runs(single, made, first, threads, progress)
    except KeyboardInterrupt:
        pass  # members that were not run say so
    rows.complete(made)
    return rows.dataset()
