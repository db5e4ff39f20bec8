"""Records of a run: events, singular positions, joints that came or went, accuracy reached."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.object_display import LISTED, listed, without_rounding
from codegen.readers.calls import readable_class
from runtime.core.kinds import SLIDING, Direction
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import Watched
from runtime.results.assembled_state import State
from runtime.results.event_text import event_text
from runtime.results.samples import FloatArray, plain

Kind = Literal["crossing", "lock-up", "start", "unclear"]

_SINGULAR = (Direction.CROSSED, Direction.LOCKED)
_SMALL = 0.02  # layout: part of the largest share, below which a text leaves a share out
_MOVED = 4  # layout: shares that a text has where bodies in space turn


@readable_class
class Event(NamedTuple):
    """A change of a mode, an impact, or a singular configuration.

    Attributes
    ----------
    name
        `effect: condition`, as `Result.mode` takes it; for a singular position its drivers and
        joints, as `singular: drive, A, B`. The effect alone is `element`.
    time
        In s; where bouncing ends, the instant at which the last flight would end.
    direction
        1: the condition began to hold, or a contact opened; -1: it ceased; 0: from now on the
        motion stays on its boundary: it slides there, friction sticks, a contact is closed, or
        a one-way clutch grips; 2: an impact, after which the contact is open; 3: a singular
        position was crossed; 4: the machine locked up in one.
    q, v
        State, shape (n,); after an impact, the velocities that it leaves.
    word
        For contacts and stops "touches", "leaves", "rests", for strands of belts "tightens",
        "slackens"; "closes", "opens" if a damper keeps the contact from pushing; "approaches",
        "recedes" if the force that it would exert changes its sign in flight. For frictions
        "sticks", "slips", "reverses"; for one-way clutches "overruns", "grips", "strikes", "slips";
        empty for others.
    impulse
        If the rate of a law jumps: component of a reaction, as `drive.fx`, → impulse of that joint
        or driver, N s or N m s. None for other events.
    """

    name: str
    time: float
    direction: int
    q: FloatArray
    v: FloatArray
    word: str = ""
    impulse: dict[str, float] | None = None

    def __repr__(self) -> str:
        """Instant, name and direction; the state is left to `q` and `v`."""
        return f"Event at t = {self.time:.9g} s: {self.text}"

    @property
    def text(self) -> str:
        """The event in a few words: `plate touches`, `gas: x of slider passes 5 m`."""
        return f"{self.element} {self.word}" if self.word else event_text(self.name, self.direction)

    @property
    def element(self) -> str:
        """The contact, friction, force or driver of the event; "" for a singular position."""
        return "" if self.direction in _SINGULAR else self.name.partition(":")[0]

    @property
    def what(self) -> str:
        """The direction in a word: began, ceased, holds, impact, crossed or locked."""
        return Direction(self.direction).name.lower()

    @property
    def state(self) -> FloatArray:
        """q and v in one array, shape (2 n,)."""
        return np.concatenate([self.q, self.v])


class SingularPosition(NamedTuple):
    """A position in which constraints cease to be independent.

    With u, uᵀ Φ_q = 0, and x, Φ_q x = 0, the velocities Φ_q q̇ = ν exist where uᵀ ν = 0: there
    motions cross. Where uᵀ ν ≠ 0 no motion follows the driver: a lock-up (E. J. Haug, Computer
    Aided Kinematics and Dynamics of Mechanical Systems I, 1989, section 3.7).

    Attributes
    ----------
    kind
        "crossing": motions cross, and the run went on along the one on which the velocity is
        continuous; "lock-up": the drivers cannot go on; "start": a crossing in which it began;
        "unclear": the run ended where two motions are too much alike, in a corner, or too near to
        several of these to be distinguished from them.
    time
        In s.
    drivers, joints
        Those whose constraints became dependent, the largest share first.
    lost
        How many constraints ceased to be independent.
    null_directions
        Directions free with the drivers at rest, one a constraint lost: coordinates with their
        shares, lengths in units of `size`, the largest share 1. For a null vector of Φ_q, in m and
        rad, multiply the shares of lengths by `size`.
    singular_value
        The smallest of Φ_q, lengths in units of `size`, rows of unit length.
    drift
        |uᵀ ν| in units of the drivers' pace, the largest |ν|: rounding where motions cross.
    q, v
        State, shape (n,); velocities without a bound are nan.
    size
        The machine's size, in m: a length typical of it, by which shares of lengths are measured.

    For a crossing a simulation keeps only the constraint with the largest share and one direction
    besides the motion's; the state is None, and `singular_value` and `drift` are nan.
    """

    kind: Kind
    time: float
    drivers: tuple[str, ...]
    joints: tuple[str, ...]
    lost: int
    null_directions: tuple[Mapping[str, float], ...]
    singular_value: float
    drift: float
    q: FloatArray | None = None
    v: FloatArray | None = None
    size: float = np.nan

    def __repr__(self) -> str:
        """Kind, instant, what is in it, and the free directions; the state is left to `q`, `v`."""
        free = f"; free {self.free}" if self.null_directions else ""
        return f"SingularPosition, {self.kind}, at t = {self.time:.9g} s: {self.title}{free}"

    @property
    def title(self) -> str:
        """`singular: drive, A, B`, as events name it."""
        return f"singular: {', '.join((*self.drivers, *self.joints))}"

    def facts(self) -> dict[str, Any]:
        """All but the state as JSON; not a number becomes None."""
        facts = self._asdict().items()
        return {name: plain(value) for name, value in facts if name not in {"q", "v"}}

    @property
    def free(self) -> str:
        """The null directions as text."""
        return "; ".join(shares(direction) for direction in self.null_directions)


def shares(direction: Mapping[str, float]) -> str:
    """The larger shares of a direction as text, the largest first; of Euler parameters an angle."""
    found: dict[str, float] = {}
    for name, part in direction.items():
        body, _, letter = name.rpartition(".")
        turns = letter in ("e0", "e1", "e2", "e3")
        word = f"orientation of {body}" if turns else name
        found[word] = float(np.hypot(2.0 * part, found.get(word, 0.0))) if turns else part
    largest = max(map(abs, found.values()), default=0.0)
    shown = sorted(found.items(), key=lambda item: -abs(item[1]))
    large = [(name, part) for name, part in shown if abs(part) > _SMALL * largest]
    texts = (f"{name} {part:{'+' * (name in direction)}.3g}" for name, part in large)
    return listed(texts, "", LISTED if len(found) == len(direction) else _MOVED)


_CONTACTS = ("contact", "stop", "clearance joint", "gear with backlash", "elastic belt")
_RIGID = {
    Direction.BEGAN: "leaves", Direction.CEASED: "touches", Direction.HOLDS: "rests",
    Direction.IMPACT: "touches",
}  # fmt: skip
_FREEWHEEL = {Direction.BEGAN: "overruns", Direction.HOLDS: "grips", Direction.IMPACT: "strikes"}
_SLIPPING = {Direction.BEGAN: "slips", Direction.CEASED: "overruns", Direction.HOLDS: "grips"}
_PUSHES = {"elastic belt": ("tightens", "slackens")}
_WORD = re.compile(r"\w+")


def _sides(description: Description) -> dict[int, tuple[int, ...]]:
    """Switch of a spring along a gap → those of its side: the gap, and the bound of its push."""
    rates = {row.velocity.replace(".", "_") for row in description.coordinates}
    switches, found = description.switches, dict[int, tuple[int, ...]]()
    for effect in description.effects:
        if effect.kind in _CONTACTS:
            own = [k for k, row in enumerate(switches) if row.name == effect.name]
            bounds = [k for k in own if rates & {*_WORD.findall(switches[k].condition)}]
            gaps = [k for k in own if k not in bounds]
            found |= {k: (k,) for k in own}
            for side in zip(gaps, bounds, strict=True) if len(gaps) == len(bounds) else ():
                found |= dict.fromkeys(side, side)
    return found


def event_words(
    description: Description, switches: Iterable[int], directions: Iterable[int],
    first_modes: npt.NDArray[np.int64],
) -> list[str]:  # fmt: skip
    """A word for each event, in their order; empty where its condition says more.

    `first_modes`, (1, s) or empty, are those in which the run began. Springs along gaps push while
    a gap is closed and no damper outweighs them.
    """
    modes = first_modes[0].tolist() if len(first_modes) else []
    stuck = {k: mode == SLIDING for k, mode in enumerate(modes)}
    holds = {k: mode != 0 for k, mode in enumerate(modes)}
    sides, words = _sides(description), []
    kinds = {row.name: row.kind for row in description.effects}

    def pushes(side: tuple[int, ...]) -> bool:
        return all(holds.get(k, False) for k in side)

    for k, direction in zip(map(int, switches), map(int, directions), strict=True):
        row = description.switches[k] if k < len(description.switches) else None
        word = ""
        if row is not None and row.kind == "contact":
            word = _RIGID.get(Direction(direction), "")
        elif row is not None and row.one_way:
            word = _FREEWHEEL.get(Direction(direction), "")
        elif row is not None and kinds.get(row.name) == "one-way clutch":
            word = _SLIPPING.get(Direction(direction), "")
        elif row is not None and row.sticks:
            held, stuck[k] = stuck.get(k, False), direction == Direction.HOLDS
            word = "sticks" if stuck[k] else "slips" if held else "reverses"
        elif row is not None and (side := sides.get(k)):
            pushed, holds[k] = pushes(side), direction != Direction.CEASED
            if direction == Direction.HOLDS:
                word = "rests"
            elif pushes(side) != pushed:
                word = _PUSHES.get(kinds[row.name], ("touches", "leaves"))[pushed]
            elif k == side[0]:
                word = "closes" if holds[k] else "opens"
            else:  # its damper, in flight
                word = "approaches" if holds[k] else "recedes"
        words.append(word)
    return words


_SHOWN = 4  # layout: changes of joints that a message tells


class Ending(NamedTuple):
    """The end of a part of a run, where joints come or go."""

    rows: tuple[Watched, ...]  # of all conditions that begin to hold
    state: State  # with clocks and conditions
    length: float  # typical of the machine, m


class Reconnection(NamedTuple):
    """A joint that came or went."""

    time: float  # s
    joint: str
    action: str  # "release" or "engage"
    # component → impulse of the joint on its second body, N s or N m s; empty at a release
    impulse: dict[str, float]
    # J, that the impact took: T⁻ - T⁺, and the work of drivers and moving places; of joints that
    # engage at one instant the first has that of their one impact, the others 0
    energy_lost: float
    units: dict[str, str]  # component → unit of its impulse, "" of an expression without one
    opposite: bool = False  # it engaged in space with axes that are opposite to the drawing

    @property
    def text(self) -> str:
        """What happened, in a few words: `joint sling is released`."""
        return f"joint {self.joint} {'engages' if self.action == 'engage' else 'is released'}"

    def __str__(self) -> str:
        """In a sentence."""
        if self.action == "release":
            return f"Joint '{self.joint}' was released at t = {self.time:.9g} s."
        values = without_rounding(self.impulse.values())
        rows = zip(self.impulse, values, self.units.values(), strict=True)
        parts = ", ".join(f"{name} {value:.6g} {unit}".rstrip() for name, value, unit in rows)
        took = f", which took {self.energy_lost:.6g} J" if self.energy_lost else ""
        begun = f"Joint '{self.joint}' engaged at t = {self.time:.9g} s"
        axes = ", its axes opposite to the drawing," if self.opposite else ""
        return f"{begun}{axes} with the impulse ({parts}){took}."


def sentences(changes: Sequence[Reconnection]) -> str:
    """What happened to the joints; of many changes the first and the last ones."""
    texts = [str(change) for change in changes]
    if len(texts) > _SHOWN:
        half = _SHOWN // 2
        rest = f"… {len(texts) - 2 * half} more changes, in `reconnections` …"
        texts = [*texts[:half], rest, *texts[-half:]]
    return " ".join(texts)


@dataclass(frozen=True)
class Estimate:
    """The global error of one quantity."""

    name: str  # of the series
    scale: float  # s in the error |y - r| / (s + |r|), in its unit
    error: float  # the largest at the output instants, as estimated
    time: float  # instant of the largest error, s


@dataclass(frozen=True)
class Trial:
    """One of the runs."""

    method: str
    formulation: str
    rtol: float
    seconds: float  # processor time of the integration
    evaluations: int  # calls of `accelerations`
    steps: int  # accepted ones
    events: int  # changes of modes
    outcome: str  # name of its `Outcome`
    # largest scaled one from the run with which it was compared; None for the first
    difference: float | None


@dataclass(frozen=True)
class ReachedAccuracy:
    """The accuracy target of a simulation, and the accuracy reached."""

    asked: float  # the target: the largest permitted relative global error
    # The largest error of the quantities, to a factor of ten or so; over the whole simulated time,
    # also where the result ends at the horizon.
    estimated: float
    quantities: tuple[Estimate, ...]  # the estimate of each, the worst first
    method: str  # as formulation and rtol: of the run that is the result
    formulation: str
    rtol: float
    runs: tuple[Trial, ...]  # all, in their order
    # last output instant up to which the target is met, s; None where it is met at all
    horizon: float | None
    tenfold: float | None  # time in which errors grow tenfold, s, if they grow exponentially
    means: str  # the evidence for the estimate, in a sentence
    seconds: float  # processor time of all integrations

    def __repr__(self) -> str:
        """Error, evidence and cost, a line each; `facts` has every number."""
        return "\n  ".join(self.sentences())

    @property
    def reached(self) -> bool:
        """Whether the target is met at all output instants."""
        return self.horizon is None

    @property
    def chaotic(self) -> bool:
        """Whether errors grow exponentially."""
        return self.tenfold is not None

    def sentences(self) -> list[str]:
        """Error, evidence and cost."""
        worst, settings = self.quantities[0], (self.method, self.formulation, self.rtol)
        delivered = next(
            run for run in self.runs if (run.method, run.formulation, run.rtol) == settings
        )
        error = (
            f"Global error estimated as about {self.estimated:.1e}, target {self.asked:.1e}; the "
            f"largest is that of {worst.name} at t = {worst.time:.6g} s."
        )
        cost = (
            f"Cost: {self.seconds * 1e3:.3g} ms of integration in {len(self.runs)} runs, this one "
            f"{delivered.seconds * 1e3:.3g} ms. Settings: {self.method}, {self.formulation}, "
            f"rtol = {self.rtol:.1e}."
        )
        lines = [error, self.means, cost]
        if self.tenfold is not None:
            lines.append(f"Errors grow tenfold every {self.tenfold:.3g} s: the motion is chaotic.")
        return lines

    def facts(self) -> dict[str, Any]:
        """All fields, as JSON; a number that is not finite is null."""
        facts: dict[str, Any] = plain(asdict(self))
        return {**facts, "reached": self.reached, "chaotic": self.chaotic}
