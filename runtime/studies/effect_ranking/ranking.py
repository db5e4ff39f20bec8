"""What is told of a scene whose effects were judged; nothing here computes."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from runtime.results.json_values import plain


class Verdict(StrEnum):
    """What becomes of the quantity without an effect, or with something taken otherwise."""

    MATTERS = "matters"
    """The quantity changes, by more than is permitted where a limit was given."""
    NEGLIGIBLE = "negligible"
    """It changes, and stays within the limit with all that it may be off."""
    NONE_SEEN = "none seen"
    """It changes by less than it is known to."""
    NEEDED = "needed"
    """Without it the machine does not work, or has no such quantity."""
    IMPOSSIBLE = "impossible"
    """Taken so, the machine does not work, or has no such quantity."""


@dataclass(frozen=True)
class Costs:
    """What a run takes.

    Attributes
    ----------
    accelerations, operations
        Arithmetic operations of the kernel `accelerations`, and of all kernels.
    evaluations, steps, events
        What the run counts; 0 where its analysis counts none.
    work
        Operations that evaluations and returns onto the constraints take together in the run;
        those of all kernels, once, where none are counted. Unlike times it is the same every time.
    seconds
        Processor time of the run from its call to its result, assembly and outputs included: the
        least of several rounds in which all scenes take turns.
    """

    accelerations: int
    operations: int
    evaluations: int
    steps: int
    events: int
    work: int
    seconds: float


@dataclass(frozen=True)
class Row:
    """One effect left out, or one thing taken otherwise.

    Attributes
    ----------
    name, kind, word
        The element, what it is, and how it is taken: "none", or a fidelity.
    scene
        The scene that was run.
    value, change
        The quantity there, and by how much it differs from the full scene's, in its unit; None
        where there is none.
    relative
        |change| over the quantity's size.
    doubt
        By how much the change may be off, in the quantity's unit.
    costs
        Of the run; None where it failed.
    time_share
        Share of the full run's time that goes with it; negative where the run takes longer.
    reason
        Why it is needed or impossible, in a sentence; else "".
    """

    name: str
    kind: str
    word: str
    scene: str
    value: float | None
    change: float | None
    relative: float | None
    doubt: float
    costs: Costs | None
    time_share: float | None
    verdict: Verdict
    reason: str = ""

    @property
    def title(self) -> str:
        """``gas``, or ``rod as link``."""
        return self.name if self.word == "none" else f"{self.name} as {self.word}"


@dataclass(frozen=True)
class Proposal:
    """The cheapest scene that was found to keep the quantity within the limit.

    Attributes
    ----------
    left_out
        Titles of the changes that it makes; none where nothing can be spared.
    put_back
        Changes that are negligible alone, and too much with the others.
    scene, spelled
        Its name, and how it is made from a declared one.
    relative, doubt
        Its change of the quantity over the quantity's size, as run; by how much that may be off.
    tried
        Every combination that was run, with what it changed (None: it does not work).
    """

    left_out: tuple[str, ...]
    put_back: tuple[str, ...]
    scene: str
    spelled: str
    value: float
    relative: float
    doubt: float
    costs: Costs
    time_share: float
    tried: tuple[tuple[tuple[str, ...], float | None], ...]


@dataclass(frozen=True)
class Matters:
    """Which effects of a scene a question calls for, those that change it most first.

    Attributes
    ----------
    value, unit, doubt
        The quantity in the full scene, and by how much it may be off.
    size
        What changes are relative to: |value|, or where that is zero within its doubt the largest
        magnitude on the way.
    error
        The limit that was given, or None.
    notes
        What else there is to know, a sentence each.
    """

    model: str
    scene: str
    analysis: str
    quantity: str
    value: float
    unit: str
    size: float
    doubt: float
    costs: Costs
    rows: tuple[Row, ...]
    error: float | None = None
    proposal: Proposal | None = None
    notes: tuple[str, ...] = ()

    def __getitem__(self, title: str) -> Row:
        """The row of an effect, or of ``"rod as link"``."""
        for row in self.rows:
            if row.title == title:
                return row
        raise KeyError(f"{title!r}; there are: {', '.join(row.title for row in self.rows)}")

    def facts(self) -> dict[str, Any]:
        """Everything, as JSON knows it: what is no finite number is null."""
        facts: dict[str, Any] = plain(asdict(self))
        return facts
