"""An effect ranking as data: rows, costs, verdicts, the proposed scene."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from runtime.results.samples import plain


class Verdict(StrEnum):
    """The influence on the quantity of an effect, or of another fidelity."""

    MATTERS = "matters"
    """The quantity changes, by more than the permitted error if one was given."""
    NEGLIGIBLE = "negligible"
    """It changes, and stays within the permitted error together with its uncertainty."""
    NONE_SEEN = "none seen"
    """It changes by less than its uncertainty."""
    NEEDED = "needed"
    """Without it the machine does not work, or has no such quantity."""
    IMPOSSIBLE = "impossible"
    """In this fidelity the machine does not work, or has no such quantity."""


@dataclass(frozen=True)
class Costs:
    """The cost of a run.

    Attributes
    ----------
    accelerations, operations
        Arithmetic operations of the kernel `accelerations`, and of all kernels.
    evaluations, steps, events
        Of the run; 0 where its analysis counts none.
    work
        Operations of all evaluations and returns onto the constraints in the run; those of all
        kernels, once, where none are counted. Unlike times it is reproducible.
    seconds
        Processor time of the run from its call to its result, with assembly and outputs: the least
        of several rounds in which all scenes take turns.
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
    """One effect left out, or one thing in another fidelity.

    Attributes
    ----------
    name, kind, word
        The element, its kind, and its fidelity; "none" if it is left out.
    scene
        The scene that was run.
    value, change
        The quantity, and its difference from that of the full scene, in its unit; None where there
        is none.
    relative
        |change| over the quantity's size.
    doubt
        Uncertainty of the change, in the quantity's unit.
    costs
        Of the run; None where it failed.
    time_share
        Share of the full run's time that is saved; negative where the run takes longer.
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
    """The cheapest scene that was found to keep the quantity within the permitted error.

    Attributes
    ----------
    left_out
        Titles of its changes; none where nothing can be left out.
    put_back
        Changes that are negligible alone, but not together with the others.
    scene, spelled
        Its name, and its derivation from a declared scene.
    relative, doubt
        Its relative change of the quantity, as run, and the uncertainty of that.
    tried
        Every combination that was run, with its relative change (None: it does not work).
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
    """The effects of a scene, those first that change a quantity most.

    Attributes
    ----------
    value, unit, doubt
        The quantity in the full scene, and its uncertainty.
    size
        Divisor of relative changes: |value|, or where that is zero within its uncertainty the
        largest magnitude during the run.
    error
        The permitted relative change, or None.
    notes
        Remarks, a sentence each.
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
        """All fields, as JSON; a number that is not finite is null."""
        facts: dict[str, Any] = plain(asdict(self))
        return facts
