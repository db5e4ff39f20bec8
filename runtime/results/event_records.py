"""Events of a result: changes of modes and impacts, in a word, and singular configurations."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.readers.calls import readable_class
from runtime.core.kinds import SLIDING, Direction
from runtime.mechanism.module_tables import Description
from runtime.results.samples import plain

FloatArray = npt.NDArray[np.float64]
Kind = Literal["crossing", "lock-up", "start", "unclear"]

_SINGULAR = (Direction.CROSSED, Direction.LOCKED)
_SMALL = 0.02  # layout: part of the largest share, below which a text leaves a share out
_MOST = 8  # layout: shares that a text shows
_LONGEST = 60  # layout: characters of a condition in the text of an event


@readable_class
class Event(NamedTuple):
    """A change of a mode, an impact, or a singular configuration.

    Attributes
    ----------
    name
        `effect: condition`, as `Result.mode` takes it; of a singular position its drivers and
        joints, as `singular: drive, A, B`. The effect alone is `element`.
    time
        In s; where bouncing ends, the instant at which its last flight would.
    direction
        1: the condition began to hold, or a contact opened; -1: it ceased; 0: from now on the
        motion stays on its boundary: it slides there, friction sticks, a contact is closed, or
        a one-way clutch grips; 2: an impact, after which the contact is open; 3: a singular
        position was crossed; 4: the machine locked up in one.
    q, v
        State, shape (n,); after an impact, the velocities that it leaves.
    word
        Of contacts and stops "touches", "leaves", "rests"; of a gap that closes or opens while a
        damper keeps it from pushing, "closes", "opens"; of frictions "sticks", "slips", "reverses";
        of one-way clutches without a capacity "overruns", "grips", "strikes"; empty for others.
    """

    name: str
    time: float
    direction: int
    q: FloatArray
    v: FloatArray
    word: str = ""

    def __repr__(self) -> str:
        """Instant, name and direction; the state is left to `q` and `v`."""
        return f"Event at t = {self.time:.9g} s: {self.text}"

    @property
    def text(self) -> str:
        """What happened, in a few words: `plate touches`, `gas: slider_vx > 0 began`."""
        if self.word:
            return f"{self.element} {self.word}"
        name, what = self.name, self.what
        return f"{name[:_LONGEST] + ' …' if len(name) > _LONGEST else name}, {what}"

    @property
    def element(self) -> str:
        """The contact, friction, force or driver whose event it is; "" of a singular position."""
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
    motions cross. Where uᵀ ν ≠ 0 the driver asks for what no motion gives: a lock-up (E. J. Haug,
    Computer Aided Kinematics and Dynamics of Mechanical Systems I, 1989, section 3.7).

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
        Those whose constraints are in what was lost, the largest share first.
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
        State, shape (n,); velocities that no bound holds are not numbers.
    size
        The machine's size, in m: a length typical of it, by which shares of lengths are measured.

    A simulation keeps less of a crossing: the constraint with the largest share, one direction
    besides the motion's, no state (None), and neither `singular_value` nor `drift` (not a number).
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
    """The larger shares of a direction as text, the largest first."""
    largest = max(map(abs, direction.values()), default=0.0)
    shown = sorted(direction.items(), key=lambda item: -abs(item[1]))
    texts = [f"{name} {part:+.3g}" for name, part in shown if abs(part) > _SMALL * largest]
    rest = len(texts) - _MOST
    return ", ".join(texts[:_MOST]) + (f" and {rest} more" if rest > 0 else "")


_CONTACTS = ("contact", "stop", "clearance joint", "gear with backlash")  # springs along gaps
_RIGID = {
    Direction.BEGAN: "leaves", Direction.CEASED: "touches", Direction.HOLDS: "rests",
    Direction.IMPACT: "touches",
}  # fmt: skip
_FREEWHEEL = {
    Direction.BEGAN: "overruns", Direction.HOLDS: "grips", Direction.IMPACT: "strikes",
}  # fmt: skip
_WORD = re.compile(r"\w+")


class _Springs:
    """What springs along gaps do: they push while a gap is closed and no damper outweighs them."""

    def __init__(self, description: Description, modes: Sequence[int]) -> None:
        rates = {row.velocity.replace(".", "_") for row in description.coordinates}
        self.holds = {k: mode != 0 for k, mode in enumerate(modes)}
        self.sides: dict[int, tuple[int, ...]] = {}  # switch → those of its side, the gap's first
        for effect in description.effects:
            own = [k for k, row in enumerate(description.switches) if row.name == effect.name]
            if effect.kind not in _CONTACTS:
                continue
            bounds = [k for k in own if rates & {*_WORD.findall(description.switches[k].condition)}]
            gaps = [k for k in own if k not in bounds]
            paired = len(bounds) == len(gaps)
            for number, gap in enumerate(gaps):
                side = (gap, bounds[number]) if paired else (gap,)
                self.sides |= dict.fromkeys(side, side)

    def word(self, switch: int, direction: int) -> str:
        """The word for an event, which is noted; empty where nothing pushes or ceases to."""
        side = self.sides.get(switch, (switch,))
        pushed = all(self.holds.get(k, False) for k in side)
        self.holds[switch] = direction != Direction.CEASED
        pushes = all(self.holds.get(k, False) for k in side)
        if direction == Direction.HOLDS:
            return "rests"
        if pushes != pushed:
            return "touches" if pushes else "leaves"
        if switch != side[0]:
            return ""
        return "closes" if self.holds[switch] else "opens"


def event_words(
    description: Description, switches: Iterable[int], directions: Iterable[int],
    first_modes: npt.NDArray[np.int64],
) -> list[str]:  # fmt: skip
    """A word for each event, in their order; empty where its condition says more.

    `first_modes`, (1, s) or empty, are those in which the run began.
    """
    kinds = {row.name: row.kind for row in description.effects}
    modes = first_modes[0].tolist() if len(first_modes) else []
    stuck = {k: mode == SLIDING for k, mode in enumerate(modes)}
    springs = _Springs(description, modes)
    words = []
    for k, direction in zip(map(int, switches), map(int, directions), strict=True):
        row = description.switches[k] if k < len(description.switches) else None
        word = ""
        if row is not None and row.kind == "contact":
            word = _RIGID.get(Direction(direction), "")
        elif row is not None and row.one_way:
            word = _FREEWHEEL.get(Direction(direction), "")
        elif row is not None and row.sticks:
            held, stuck[k] = stuck.get(k, False), direction == Direction.HOLDS
            word = "sticks" if stuck[k] else "slips" if held else "reverses"
        elif row is not None and kinds.get(row.name) in _CONTACTS:
            word = springs.word(k, direction)
        words.append(word)
    return words
