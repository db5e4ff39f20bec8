"""Checkpoints of a run: states of its arrays, from which it is retaken with the same bits.

All that a run needs to go on lies in its arrays, so that copies of these are a place to begin at.
They are made between chunks of steps, which costs a run nothing that can be measured. The motion at
any instant is then the run from the checkpoint before it, with the samples that are asked for.
"""

import time
from bisect import bisect_left
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

from runtime.core import function_table_slots as ft
from runtime.core.array_types import Integers, Vector
from runtime.core.loop_record import Plan
from runtime.core.outcomes import Outcome
from runtime.integrate.run import Change, Run
from runtime.integrate.step import Signal

_SPACING = 0.02  # measured: s of computing between two; what a look at an instant may take
_MOST_BYTES = 2**25  # safety: of all; where they are more, every second is dropped
_GOING, _OK = int(Signal.GOING), int(Outcome.OK)
_NUMBERS = [ft.MODIFIED, ft.SLIDING_COUNT, ft.STABILIZED, ft.EACH_STAGE, ft.CORRECTING]


class Snapshot(NamedTuple):
    """The state of one `Run`, in copies."""

    record: Any  # (1,), of the type `RUN`
    block: Integers  # all arrays of the table that are not made elsewhere
    numbers: Integers  # of the table, those that change
    p: Vector  # parameters, with what the kernels take from them in sliding modes
    methods: tuple[tuple[float, str], ...]
    part: int  # of the instants known beforehand
    crossings: tuple[Any, ...]

    @property
    def nbytes(self) -> int:
        """Bytes that it takes."""
        return int(self.block.nbytes + self.record.nbytes + self.p.nbytes)


def snapshot(run: Run) -> Snapshot:
    """The state of a run that stands between two steps, away from singular positions."""
    state, crossings = run.state, run.crossings
    found = crossings.note, crossings.tries, crossings.began
    return Snapshot(
        state.wiring.arrays["record"].copy(), state.wiring.block.copy(), state.table[_NUMBERS],
        state.p.copy(), tuple(state.methods), state.part,
        (*found, tuple(crossings.passed), crossings.positions.orders.known),
    )  # fmt: skip


def restore(run: Run, kept: Snapshot) -> None:
    """Put a fresh run of the same problem where another stood; it writes its own samples."""
    state, crossings, sampling = run.state, run.crossings, int(run.state.record["every_step"])
    for _ in range(kept.part):
        state.set_further_stops()
    state.wiring.arrays["record"][:] = kept.record
    state.wiring.block[:] = kept.block
    state.table[_NUMBERS], state.p[:] = kept.numbers, kept.p
    state.methods = list(kept.methods)
    state.set_functions(state.methods[-1][1])
    r = state.record
    r["every_step"], r["samples"], r["next_sample"] = sampling, 0, 0
    crossings.note, crossings.tries, crossings.began, passed, known = kept.crossings
    crossings.passed = list(passed)
    crossings.positions.orders.known = known


class Checkpoint(NamedTuple):
    """Where a run stood between two steps."""

    t: float  # s
    state: Any  # a `Snapshot`, or what changes of coordinates make of those of their runs


class Keeper(Protocol):
    """What changes the coordinates of a run."""

    def __call__(self, run: Run, code: int) -> tuple[Run, int]:
        """A `Change`."""

    def snapshot(self) -> Any:
        """The state of all its runs, which tells its `nbytes`."""


class Checkpoints:
    """The checkpoints of one run, in order of time; the `Change` that makes them."""

    def __init__(self, change: Keeper | None = None) -> None:
        self.change = change
        self.rows: list[Checkpoint] = []
        self.spacing, self.bytes = _SPACING, 0
        self.due = time.perf_counter() + self.spacing

    def __call__(self, run: Run, code: int) -> tuple[Run, int]:
        """Make a checkpoint where the last one was made long ago."""
        if self.change is not None:
            run, code = self.change(run, code)
        if code == _GOING and time.perf_counter() >= self.due:
            r = run.state.record
            if r["plan"] == Plan.FREE and not r["lent"]:
                kept = snapshot(run) if self.change is None else self.change.snapshot()
                self._add(Checkpoint(float(r["t"]), kept))
        return run, code

    def _add(self, row: Checkpoint) -> None:
        self.rows.append(row)
        self.bytes += row.state.nbytes
        if self.bytes > _MOST_BYTES and len(self.rows) > 2:
            self.rows, self.spacing = self.rows[::2], 2.0 * self.spacing
            self.bytes = sum(kept.state.nbytes for kept in self.rows)
        self.due = time.perf_counter() + self.spacing

    def before(self, t: float) -> Checkpoint | None:
        """The last checkpoint before the instant `t`, s; None: only the start of the run is."""
        place = bisect_left(self.rows, t, key=lambda row: row.t)
        return self.rows[place - 1] if place else None

    def groups(self, times: Sequence[float]) -> list[tuple[Checkpoint | None, slice]]:
        """Ascending instants, by the checkpoints before them."""
        starts = [self.before(t) for t in times]
        cuts = [k for k in range(len(times)) if k == 0 or starts[k] is not starts[k - 1]]
        ends = [*cuts[1:], len(times)]
        return [(starts[a], slice(a, b)) for a, b in zip(cuts, ends, strict=True)]


class Until:
    """A `Change` that ends a run as soon as it has passed an instant, s."""

    def __init__(self, last: float, change: Change | None = None) -> None:
        self.last, self.change = last, change

    def __call__(self, run: Run, code: int) -> tuple[Run, int]:
        """What the other change says, unless the instant lies behind."""
        if self.change is not None:
            run, code = self.change(run, code)
        if code == _GOING and run.state.record["t"] >= self.last:
            code = _OK
        return run, code
