"""The runs of an ensemble, one after the other, as rows of one dataset."""

from typing import TYPE_CHECKING, Any

from codegen.errors import InputError, LinkwrightError
from runtime.core.outcomes import Outcome
from runtime.dynamics.simulation import simulate
from runtime.ensemble.dataset import Rows
from runtime.ensemble.members import Columns, FloatArray, read_members, require_room
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.progress_bar import Progress

if TYPE_CHECKING:
    import xarray as xr


def run_ensemble(
    mechanism: Mechanism, t_end: float, times: FloatArray, parameters: Columns | None,
    starts: Columns | None, max_bytes: int, progress: Progress, **options: Any,
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
    try:
        for run in range(members.count):
            start = members.start_of(run) or None
            values = members.parameters_of(run) or None
            try:
                result = simulate(
                    mechanism, t_end, times, parameters=values, start=start, **options
                )
            except LinkwrightError as error:
                rows.refuse(run, error)
            else:
                rows.take(run, result)
                if result.outcome is Outcome.INTERRUPTED:
                    break
            progress((run + 1) / members.count)
    except KeyboardInterrupt:
        pass  # members that were not run say so
    return rows.dataset()
