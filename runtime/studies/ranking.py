"""An effect ranking as data: rows, costs, verdicts, the proposed scene; its sentences and table."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from operator import attrgetter, sub
from typing import TYPE_CHECKING

from codegen.presentation import in_pyplot, new_table, shortened
from codegen.readers.calls import checked_class
from runtime.studies.answer import Answer, titled
from runtime.studies.harness import LEFT_OUT

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.table import Table

_LONGEST_REASON = 200  # characters
_COUNTS = attrgetter("accelerations", "operations", "steps", "events")


class Verdict(StrEnum):
    """The influence on the quantity of an effect, or of another fidelity."""

    MATTERS = "matters"  # the quantity changes, by more than the permitted error if one was given
    NEGLIGIBLE = "negligible"  # it changes, and together with its uncertainty is within the error
    NONE_SEEN = "none seen"  # it changes by less than its uncertainty
    NEEDED = "needed"  # without it the machine does not work, or has no such quantity
    IMPOSSIBLE = "impossible"  # in this fidelity the machine does not work, or has no such quantity


@dataclass(frozen=True)
class Costs:
    """The cost of a run."""

    accelerations: int  # arithmetic operations of the kernel `accelerations`
    operations: int  # of all kernels
    evaluations: int  # of the run, as are steps and events; 0 where its analysis counts none
    steps: int
    events: int
    # of all evaluations and calls of `correction` in the run; that of all kernels, once,
    # where none are counted; unlike times it is reproducible
    work: int
    seconds: float  # processor time with assembly and outputs, the least of rounds in turns


@dataclass(frozen=True)
class Row:
    """One effect left out, or one thing in another fidelity."""

    name: str
    kind: str
    word: str  # the fidelity; "none" if it is left out
    scene: str  # that was run
    verdict: Verdict
    reason: str = ""  # why it is needed or impossible, in a sentence; no numbers follow
    value: float | None = None  # of the quantity
    change: float | None = None  # from the full scene, in the quantity's unit
    relative: float | None = None  # |change| over the quantity's size
    doubt: float = 0.0  # uncertainty of the change, in the quantity's unit
    costs: Costs | None = None  # of the run
    time_share: float | None = None  # of the full run that is saved; negative where it is longer

    @property
    def title(self) -> str:
        """``gas``, or ``rod as link``."""
        return self.name if self.word == LEFT_OUT else f"{self.name} as {self.word}"

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """Needed and impossible first, then by change; changes below their uncertainty last."""
        unseen = self.verdict is Verdict.NONE_SEEN
        return self.change is not None, unseen, -(self.relative or 0.0)


@dataclass(frozen=True)
class Proposal:
    """The cheapest scene that was found to keep the quantity within the permitted error."""

    left_out: tuple[str, ...]  # titles of its changes; none where nothing can be left out
    put_back: tuple[str, ...]  # changes that are negligible alone, but not with the others
    scene: str
    spelled: str  # its derivation from a declared scene
    value: float
    relative: float  # change of the quantity, as run
    doubt: float  # uncertainty of that
    costs: Costs
    time_share: float
    tried: tuple[tuple[tuple[str, ...], float | None], ...]
    """Combinations that were run, with their relative change (None: it does not work)."""


@checked_class
@dataclass(frozen=True, repr=False)
class Matters(Answer):
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
        return titled("effect", {row.title: row for row in self.rows}, title)

    @in_pyplot()
    def plot(self) -> "Figure":
        """Draw what each effect changes, and its share of the time.

        Raises
        ------
        InputError
            If matplotlib is not installed.
        """
        from runtime.studies.pictures import draw_ranking

        return draw_ranking(self)

    @property
    def title(self) -> str:
        """The scene, the analysis, and the quantity with its value."""
        value = f"{self.value:.7g} {self.unit}".rstrip()
        return f"{self.model}/{self.scene}, {self.analysis}: {self.quantity} = {value}"

    def tables(self) -> "tuple[Table]":
        """The full scene; change and saving without each effect; the same of the proposal."""

        def savings(of: Row | Proposal) -> tuple[object, ...]:
            if of.costs is None:
                return ("",) * 5
            return *map(sub, _COUNTS(full), _COUNTS(of.costs)), f"{of.time_share:.0%}"

        full, proposal, rows = self.costs, self.proposal, list[tuple[object, ...]]()
        first = ("nothing", "", "", *_COUNTS(full), f"{1e3 * full.seconds:.3g} ms", "")
        last = list[tuple[object, ...]]()
        for row in self.rows:
            change = "" if row.change is None else f"{row.change:+.3g}", percent(row.relative)
            if row.verdict is Verdict.NONE_SEEN:
                change = f"< {row.doubt:.1g}", ""
            rows.append((row.title, *change, *savings(row), row.verdict))
        if proposal is not None and proposal.left_out:
            change = f"{proposal.value - self.value:+.3g}", percent(proposal.relative)
            last.append(("proposed", *change, *savings(proposal), "within error"))
        caption = (
            "acc., all: operations of the kernel accelerations and of all kernels; the first row "
            "is the full scene, the others the saving"
        )
        head = ("without", "change", "relative", "acc.", "all", "steps", "events", "time",
                "verdict")  # fmt: skip
        sections = [first], rows, last
        return (new_table(self.title, head, *sections, caption=caption, least=9),)

    def sentences(self, *, whole: bool = False) -> Iterator[str]:
        """Uncertainty, influence and cost of each effect, the proposal, notes."""
        share = f" ({self.doubt / self.size:.1e} of its size)" if self.size else ""
        doubt = f"{self.doubt:.1e} {self.unit}".rstrip()
        yield f"{self.quantity} is known to {doubt}{share}."
        for row in self.rows:
            if row.time_share is None:
                reason = row.reason if whole else shortened(row.reason, _LONGEST_REASON)
                yield f"{row.title} is {row.verdict}: {reason}"
            else:
                yield self._influence(row, row.time_share)
        if self.proposal is not None:
            yield from self._proposal(self.proposal)
        yield from self.notes

    def _influence(self, row: Row, share: float) -> str:
        limit = percent(row.doubt / self.size) if self.size else f"{row.doubt:.1e}"
        change = percent(row.relative)
        if row.verdict is Verdict.NONE_SEEN:
            change = f"less than its uncertainty ({limit})"
        effect = f"{row.title} changes {self.quantity} by {change}"
        if row.word != LEFT_OUT:
            return f"{effect} and {_saving(share)}"
        if share >= 0.0:
            return f"{effect} and costs {share:.0%} of the time"
        return f"{effect}; without it the run {_saving(share)}"

    def _proposal(self, proposal: Proposal) -> Iterator[str]:
        for titles, relative in proposal.tried:
            if titles != proposal.left_out:
                fate = "does not work" if relative is None else f"changes it by {percent(relative)}"
                yield f"together, {', '.join(titles)}: {fate}, beyond {self.error:g}"
        for title in proposal.put_back:
            yield f"{title} is negligible alone but not together with the others, so it is put back"
        if not proposal.left_out:
            yield f"nothing can be left out within an error of {self.error:g}"
            return
        yield (
            f"proposed for an error of {self.error:g}: {proposal.spelled}; when run, it changes "
            f"{self.quantity} by {percent(proposal.relative)} (known to "
            f"{percent(proposal.doubt)}) and {_saving(proposal.time_share)}"
        )


def _saving(share: float) -> str:
    return f"saves {share:.0%} of the time" if share >= 0 else f"takes {-share:.0%} more time"


def percent(share: float | None) -> str:
    """A share with two digits; nothing of None."""
    if share is None:
        return ""
    if not math.isfinite(share):
        return "∞"
    return f"{100 * share:.2g} %" if share < 1.0 else f"{100 * share:.0f} %"
