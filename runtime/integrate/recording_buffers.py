"""Samples, events and partitions that the compiled loop writes, taken over when it returns."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from runtime.core.arrays import IntegerMatrix, Integers, Matrix, Vector
from runtime.core.function_table_slots import EVENT_ROWS, OUT_ROWS, SAMPLE_TIMES
from runtime.core.kinds import Direction
from runtime.core.system import System
from runtime.integrate.problem import Events, Options, Partitions, Rows
from runtime.integrate.sampling import INTERVAL
from runtime.integrate.wiring import Wiring, place

_EVENT_ROWS = 64  # layout: events that fit between two returns to Python
_SINK_BYTES = 2**22  # measured: bytes of samples between two returns to Python, if there is a sink
_LEAST_WINDOW = 64  # safety: rows of room for them
_EVENTS = ("event_times", "event_kinds", "event_states")
_SAMPLES = ("out_times", "out_states", "out_modes")


class _Rows(list[tuple[np.ndarray, ...]]):
    """Rows of some arrays, chunk by chunk."""

    def take(self, count: int, *arrays: np.ndarray) -> int:
        """Copy the first `count` rows of each array; the bytes that they take."""
        if count == 0:
            return 0
        self.append(tuple(array[:count].copy() for array in arrays))
        return sum(array.nbytes for array in self[-1])

    def joined(self, *like: np.ndarray) -> tuple[np.ndarray, ...]:
        """All rows of each array, which are of the shape of those of `like`."""
        columns = zip(like, *self, strict=True)
        return tuple(np.concatenate([first[:0], *parts]) for first, *parts in columns)


class _Outlet(_Rows):
    """Rows that go elsewhere, and take no room here."""

    def __init__(self, sink: Rows) -> None:
        super().__init__()
        self.sink = sink

    def take(self, count: int, *arrays: np.ndarray) -> int:
        """Hand copies of the first `count` rows of each array on; no bytes."""
        if count:
            self.sink(*(array[:count].copy() for array in arrays))
        return 0


class Recording:
    """Samples, events and changes of the partition of one run, for which `wiring` receives room."""

    def __init__(self, wiring: Wiring, system: System, options: Options) -> None:
        self.wiring, self.sink, t_eval = wiring, options.sink, options.t_eval
        self.n, self.s = n, s = system.coordinates, system.switches
        self.record = wiring.arrays["record"][0]
        given = t_eval is not None and not options.quadrature
        self.fixed_size = given and self.sink is None
        self.window = max(_LEAST_WINDOW, _SINK_BYTES // (8 * (2 * n + s + 1)))
        self.taken = -1  # trial steps when a chunk began
        self.interval = INTERVAL if options.quadrature else 1  # samples of one
        self.log = wiring.arrays["log_times"], wiring.arrays["log_sets"]
        self.make_room_for_events(_EVENT_ROWS + 3 * s)
        times = () if t_eval is None else t_eval
        instants = np.ascontiguousarray(times, dtype=np.float64)
        self._place(SAMPLE_TIMES, instants.size, ("sample_times",), (instants,))
        self.instants, self.bytes = instants.size, 0  # bytes: of all parts of the run so far
        self._allot(self.instants if self.fixed_size else _LEAST_WINDOW if self.sink else 1)
        self.begin()

    def make_room_for_events(self, rows: int) -> None:
        """Make room for so many events between two returns to Python, before there are any."""
        width = 2 * self.n
        self.events_out = np.zeros(rows), np.zeros((rows, 2), np.int64), np.zeros((rows, width))
        self._place(EVENT_ROWS, rows, _EVENTS, self.events_out)

    def begin(self) -> None:
        """Forget what was taken over: what follows is another part of the run."""
        self.sample_rows = _Rows() if self.sink is None else _Outlet(self.sink)
        self.event_rows, self.partition_rows = _Rows(), _Rows()
        self.first = int(self.record["samples"])

    def _place(self, count: int, rows: int, names: Iterable[str], arrays: Iterable[Any]) -> None:
        table = self.wiring.table
        table[count] = rows
        for name, array in zip(names, arrays, strict=True):
            place(table, self.wiring.arrays, name, array)

    @property
    def most_steps(self) -> int | None:
        """Steps until `flush` is called, at most; None: as many as there are."""
        return self.window if self.sink is not None and not self.instants else None

    def make_room(self, steps: int) -> None:
        """Make room for the samples of so many steps, unless their number is given.

        A sink gets them through a window, which grows where those of one step do not fit in.
        """
        size = steps if self.interval == 1 else self.interval * (steps + self.instants)
        if self.sink is not None and self.instants:
            taken = int(self.record["steps"] + self.record["rejected"])
            if taken == self.taken and self.window < self.instants:
                self.window *= 2
            self.taken, size = taken, self.window
        if not self.fixed_size and self.out[0].size != size:
            self._allot(size)

    def _allot(self, size: int) -> None:
        modes = np.zeros((size, self.s), np.int64)
        self.out: tuple[Any, ...] = np.zeros(size), np.zeros((size, 2 * self.n)), modes
        self._place(OUT_ROWS, size, _SAMPLES, self.out)

    def flush(self) -> None:
        """Take over what the last chunk wrote; samples at given instants stay where they are."""
        r = self.record
        if not self.fixed_size:
            self.bytes += self.sample_rows.take(r["samples"], *self.out)
            r["samples"] = 0
        self.bytes += self.event_rows.take(r["logged_events"], *self.events_out)
        self.bytes += self.partition_rows.take(r["logged_repartitions"], *self.log)
        r["logged_events"] = r["logged_repartitions"] = 0

    def add_sample(self, t: float, y: Vector, modes: Integers) -> None:
        """Add a sample at an instant that the loop does not see, t in s and y of shape (2 n,)."""
        if self.fixed_size:
            row = int(self.record["samples"])
            for array, value in zip(self.out, (t, y, modes), strict=True):
                array[row] = value
            self.record["samples"] += 1
        else:  # an interval of no length, its nodes before its end
            rows = (np.tile(value, (self.interval, 1)) for value in (t, y, modes))
            times, *states = rows
            self.sample_rows.take(self.interval, times[:, 0], *states)

    def replace_first(self, y: Vector, changed: Integers, modes: Integers) -> None:
        """Give the samples of the first instant, not yet taken over, the state (2 n,) behind it.

        `changed` are the switches whose modes have become others there.
        """
        _, states, seen = self.out
        count = int(self.record["samples"])
        states[:count] = y
        seen[:count, changed] = modes[changed]

    def add_events(self, t: float, switches: Integers, kinds: list[int], y: Vector) -> None:
        """Add events at one instant that the loop has not seen."""
        count, kind = len(switches), np.column_stack([switches, kinds])
        self.event_rows.take(count, np.full(count, t), kind, np.tile(y, (count, 1)))

    def samples(self) -> tuple[Vector, Matrix, IntegerMatrix]:
        """Times (k,), states (k, 2 n) and modes (k, s)."""
        if self.sink is not None:
            t, y, modes = (array[:0].copy() for array in self.out)
        elif self.fixed_size:
            t, y, modes = (array[self.first : self.record["samples"]] for array in self.out)
        else:
            t, y, modes = self.sample_rows.joined(*self.out)
        return t, y, modes

    def events(self) -> Events:
        """All events so far, as they were logged; see `in_order`."""
        t, kind, y = self.event_rows.joined(*self.events_out)
        return Events(t, kind[:, 0], kind[:, 1], y[:, : self.n], y[:, self.n :])

    def partitions(self) -> Partitions:
        """The first partition and all changes so far."""
        t, sets = self.partition_rows.joined(*self.log)
        return Partitions(t, sets.astype(bool))


def in_order(events: Events, now: float, rigid: Sequence[int]) -> Events:
    """The events of a run that has reached the instant `now`, in order of time.

    The end of bouncing of a contact, of a function among `rigid`, is logged at its last visible
    impact, with the instant at which its flights will be over: an event of the same contact, or the
    end of the run, that comes before it is the latest at which that can be; its state goes back to
    that instant. All other events stay in the order of the log, which a check judges.
    """
    t = events.t
    if not len(t) or not ((np.diff(t) < 0.0).any() or (t[-1:] > now).any()):
        return events
    limit: dict[int, float] = {}
    bounced = (events.direction == Direction.HOLDS) & np.isin(events.index, rigid)
    for i in range(len(t) - 1, -1, -1):
        k = int(events.index[i])
        if bounced[i]:
            latest = min(t[i], limit.get(k, now))
            events.q[i] += (latest - t[i]) * events.v[i]
            t[i] = latest
        limit[k] = float(t[i])
    place = t.copy()
    place[~bounced] = np.maximum.accumulate(t[~bounced])
    order = np.argsort(place, kind="stable")
    return Events(*(column[order] for column in vars(events).values()))
