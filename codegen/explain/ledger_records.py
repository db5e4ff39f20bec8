"""The ledger of a scene as plain data, and the comparison of two, part by part."""

from dataclasses import dataclass, field, replace
from itertools import chain


@dataclass(frozen=True)
class Part:
    """An element of the declaration, a fidelity of one, or work that all elements share."""

    name: str
    kind: str
    role: str  # "joint", "driver", "effect", "fidelity" or "shared"
    acts: bool  # whether it is in
    why: str  # the reason
    operations: dict[str, int] = field(default_factory=dict)  # kernel → incremental cost
    own: dict[str, int] = field(default_factory=dict)  # of an effect: kernel → marginal cost
    # Measured time that it adds to an evaluation of `accelerations`; None without a measurement.
    nanoseconds: float | None = None
    events: tuple[str, ...] = ()  # the conditions whose switching functions it brings
    # Of a run, None without one: its events, its share of the steps repeated for events (in
    # proportion to the events), and the seconds that `accelerations` spent on it.
    run_events: int | None = None
    run_retakes: float | None = None
    run_seconds: float | None = None

    @property
    def solving(self) -> int:
        """Its operations in the kernel `accelerations`."""
        return self.operations.get("accelerations", 0)

    @property
    def total(self) -> int:
        """Its operations in all kernels."""
        return sum(self.operations.values())


@dataclass(frozen=True)
class OutputEntry:
    """A word of ``outputs=``, whether the scene has it, and why."""

    name: str
    asked: bool
    why: str


@dataclass(frozen=True)
class RunCosts:
    """Costs of a run with the scene's defaults."""

    t_end: float
    evaluations: int  # of `accelerations`
    steps: int  # accepted
    rejected: int  # for their error
    retakes: int  # steps repeated for the location of events
    events: int
    seconds: float  # wall time of the integration


@dataclass(frozen=True)
class Ledger:
    """The cost of a scene by part and kernel; each operation belongs to one part."""

    model: str
    scene: str
    kernels: tuple[str, ...]  # those with operations
    parts: tuple[Part, ...]
    totals: dict[str, int]  # kernel → operations, the sum over the parts
    left_out: tuple[tuple[str, str], ...]  # (name, kind) of the elements that do not take part
    outputs: tuple[OutputEntry, ...]  # those that the scene reports or could report, and why
    # Time of an evaluation of `accelerations`, measured separately; those of the parts add up to it
    # but for the noise of the measurement.
    nanoseconds: float | None = None
    run: RunCosts | None = None
    loops: str = ""  # which kernels are in loops, and why

    @property
    def title(self) -> str:
        """Machine and scene."""
        return f"{self.model}, scene {self.scene}"

    @property
    def parts_nanoseconds(self) -> float:
        """Sum of the times of the parts."""
        return sum(part.nanoseconds or 0.0 for part in self.parts)

    @property
    def whole(self) -> Part:
        """All parts as one."""
        time = None if self.nanoseconds is None else self.parts_nanoseconds
        events = tuple(event for part in self.parts for event in part.events)
        return Part("total", "", "", True, "", self.totals, nanoseconds=time, events=events)


@dataclass(frozen=True)
class Row:
    """A part in both scenes."""

    name: str
    acts: tuple[bool | None, bool | None]  # whether it is in; None: unknown to the scene's ledger
    accelerations: tuple[int, int]  # operations of the kernel `accelerations`
    operations: tuple[int, int]  # of all kernels
    nanoseconds: tuple[float | None, float | None]  # of an evaluation of `accelerations`


@dataclass(frozen=True)
class Comparison:
    """Two ledgers side by side; `total` has no `acts`."""

    first: Ledger
    second: Ledger
    rows: tuple[Row, ...]
    total: Row


def compare(first: Ledger, second: Ledger) -> Comparison:
    """The parts of two ledgers in the order of declaration, shared work last."""
    sides = [{part.name: part for part in ledger.parts} for ledger in (first, second)]
    names = dict.fromkeys(chain(*sides))
    shared = {name for side in sides for name, part in side.items() if part.role == "shared"}
    ordered = sorted(names, key=lambda name: name in shared)
    rows = tuple(_row(name, *(side.get(name) for side in sides)) for name in ordered)
    total = replace(_row("total", first.whole, second.whole), acts=(None, None))
    return Comparison(first, second, rows, total)


def _row(name: str, one: Part | None, other: Part | None) -> Row:
    absent = Part(name, "", "", False, "")
    a, b = one or absent, other or absent
    return Row(
        name,
        (one.acts if one else None, other.acts if other else None),
        (a.solving, b.solving),
        (a.total, b.total),
        (a.nanoseconds, b.nanoseconds),
    )
