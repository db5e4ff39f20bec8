"""Checkpoints of a run: copies of its arrays, from which it can be repeated with the same bits.

All that a run needs to go on lies in its arrays, so that copies of these are a place to begin at.
They are made between chunks of steps, which costs a run nothing that can be measured. The motion at
any instant is then the run from the checkpoint before it, with the samples that are asked for.
"""

import time
from bisect import bisect_left
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from runtime.core import function_table_slots as ft
from runtime.core.arrays import Integers, Vector
from runtime.core.loop_record import Plan
from runtime.core.outcomes import Outcome
from runtime.integrate.clocks import CLOCK
from runtime.integrate.problem import Discrete
from runtime.integrate.run import Run
from runtime.integrate.step import Signal

_SPACING = 0.02  # measured: s of computing between two; as long as `Result.at` may take
_MOST_BYTES = 2**25  # safety: bytes of all; beyond it every second one is dropped
_FREE = 10.0  # safety: steps before the end of a run; earlier steps do not depend on the end
_GOING, _OK = int(Signal.GOING), int(Outcome.OK)
# What a run says for itself, of the samples and of its end.
_OWN = (
    "every_step", "samples", "next_sample", "t_end", "duration", "h_max", "h_min", "max_steps",
    "unlimited",
)  # fmt: skip
_NUMBERS = [ft.MODIFIED, ft.SLIDING_COUNT, ft.STABILIZED, ft.EACH_STAGE, ft.CORRECTING]


class Snapshot(NamedTuple):
    """The state of one `Run`, in copies."""

    record: Any  # (1,), of the type `RUN`
    block: Integers  # all arrays of the table that are not made elsewhere
    numbers: Integers  # of the table, those that change
    p: Vector  # parameters, with what the kernels take from them in sliding modes
    methods: tuple[tuple[float, str], ...]
    crossings: tuple[Any, ...]

    @property
    def nbytes(self) -> int:
        """Bytes that it takes."""
        return int(self.block.nbytes + self.record.nbytes + self.p.nbytes)

    @property
    def longest(self) -> float:
        """Length of the last step and of the next one, the larger, s."""
        return float(max(self.record["h"][0], self.record["usual"][0]))


def snapshot(run: Run) -> Snapshot:
    """The state of a run that stands between two steps, away from singular positions."""
    state, crossings, positions = run.state, run.crossings, run.crossings.positions
    found = crossings.note, crossings.tries, crossings.began
    return Snapshot(
        state.wiring.arrays["record"].copy(), state.wiring.block.copy(), state.table[_NUMBERS],
        state.p.copy(), tuple(state.methods),
        (*found, tuple(crossings.passed), positions.orders.known, positions.passed),
    )  # fmt: skip


def restore(run: Run, kept: Snapshot) -> None:
    """Put a fresh run of the same problem, perhaps with another end, where another stood.

    It writes its own samples.
    """
    state, crossings = run.state, run.crossings
    own = {name: state.record[name].item() for name in _OWN}
    state.wiring.arrays["record"][:] = kept.record
    state.wiring.block[:] = kept.block
    state.table[_NUMBERS], state.p[:] = kept.numbers, kept.p
    state.methods = list(kept.methods)
    state.set_functions(state.methods[-1][1])
    r = state.record
    for name, number in own.items():
        r[name] = number
    state.find_stop(float(r["t"]))
    crossings.note, crossings.tries, crossings.began, passed, known, points = kept.crossings
    crossings.passed = list(passed)
    crossings.positions.orders.known, crossings.positions.passed = known, points


class Checkpoint(NamedTuple):
    """Where a run stood between two steps."""

    t: float  # s
    state: Any  # a `Snapshot`, or what changes of coordinates make of those of their runs


class Checkpoints:
    """The checkpoints of one run, in order of time; the `Change` that makes them."""

    def __init__(self, rows: Sequence[Checkpoint] = (), spacing: float = 0.0) -> None:
        self.state_of: Callable[[Run], Any] = snapshot  # what a checkpoint keeps
        self.rows = list(rows)
        self.spacing, self.bytes = max(spacing, _SPACING), sum(row.state.nbytes for row in rows)
        self.due = time.perf_counter() + self.spacing

    def __call__(self, run: Run, code: int) -> tuple[Run, int]:
        """Make a checkpoint where the last one was made long ago."""
        if code == _GOING and time.perf_counter() >= self.due:
            r = run.state.record
            if r["plan"] == Plan.FREE and not r["lent"]:
                self._add(Checkpoint(float(r["t"]), self.state_of(run)))
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

    def until(self, t: float) -> "list[Checkpoint]":
        """Those on whose steps nothing shows yet of a run that ends at `t`, s."""
        return [row for row in self.rows if row.t + _FREE * row.state.longest < t]

    def groups(self, times: Sequence[float]) -> list[tuple[Checkpoint | None, slice]]:
        """Ascending instants, by the checkpoints before them."""
        starts = [self.before(t) for t in times]
        cuts = [k for k in range(len(times)) if k == 0 or starts[k] is not starts[k - 1]]
        ends = [*cuts[1:], len(times)]
        return [(starts[a], slice(a, b)) for a, b in zip(cuts, ends, strict=True)]


class Until:
    """A `Change` that ends a run as soon as it has passed an instant, s."""

    def __init__(self, last: float) -> None:
        self.last = last

    def __call__(self, run: Run, code: int) -> tuple[Run, int]:
        """OK in the place of going on, where the instant lies behind."""
        return run, _OK if code == _GOING and run.state.record["t"] >= self.last else code


class Passed(Until):
    """A `Change` that ends a run behind an instant, s, and knows where its clocks stood there.

    It has to be called after every step.
    """

    def __init__(self, last: float) -> None:
        self.passed = last + CLOCK * abs(last)  # instants nearer to each other are one
        super().__init__(float(np.nextafter(self.passed, np.inf)))
        self.stand: Discrete | None = None

    def __call__(self, run: Run, code: int) -> tuple[Run, int]:
        """As `Until`."""
        if run.state.record["t"] <= self.passed:
            self.stand = run.state.discrete
        return super().__call__(run, code)
