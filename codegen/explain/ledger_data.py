"""The ledger of a scene as plain data."""

from dataclasses import dataclass, field

from codegen.explain.inventory import OutputEntry


@dataclass(frozen=True)
class Part:
    """An element of the declaration, a fidelity of one, or work that all elements share.

    Attributes
    ----------
    role
        ``"joint"``, ``"driver"``, ``"effect"``, ``"fidelity"`` or ``"shared"``.
    acts, why
        Whether it is in, and the reason.
    operations
        Kernel → its incremental cost (`codegen.explain.operation_costs`).
    own
        Of an effect: kernel → its marginal cost.
    nanoseconds
        Measured time that it adds to an evaluation of `accelerations`; None without a measurement.
    events
        The conditions whose switching functions it brings.
    run_events, run_retakes, run_seconds
        Of a run: its events, its share of the steps repeated for events (in proportion to the
        events), and the seconds that `accelerations` spent on it. None without a run.
    """

    name: str
    kind: str
    role: str
    acts: bool
    why: str
    operations: dict[str, int] = field(default_factory=dict)
    own: dict[str, int] = field(default_factory=dict)
    nanoseconds: float | None = None
    events: tuple[str, ...] = ()
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
class RunCosts:
    """Costs of a run with the scene's defaults.

    Attributes
    ----------
    evaluations, steps, rejected, retakes
        Evaluations of `accelerations`; steps accepted, rejected for their error, and repeated for
        the location of events.
    seconds
        Wall time of the integration.
    """

    t_end: float
    evaluations: int
    steps: int
    rejected: int
    retakes: int
    events: int
    seconds: float


@dataclass(frozen=True)
class Ledger:
    """The cost of a scene by part and kernel; each operation belongs to one part.

    Attributes
    ----------
    kernels
        Those with operations.
    totals
        Kernel → operations, the sum over the parts.
    left_out
        (name, kind) of the elements that do not take part.
    outputs
        The outputs that the scene reports or could report, with the reason.
    nanoseconds
        Time of an evaluation of `accelerations`, measured separately; those of the parts add up to
        it but for the noise of the measurement.
    """

    model: str
    scene: str
    kernels: tuple[str, ...]
    parts: tuple[Part, ...]
    totals: dict[str, int]
    left_out: tuple[tuple[str, str], ...]
    outputs: tuple[OutputEntry, ...]
    nanoseconds: float | None = None
    run: RunCosts | None = None

    @property
    def title(self) -> str:
        """Machine and scene."""
        return f"{self.model}, scene {self.scene}"

    @property
    def parts_nanoseconds(self) -> float:
        """Sum of the times of the parts."""
        return sum(part.nanoseconds or 0.0 for part in self.parts)
