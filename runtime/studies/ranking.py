"""An effect ranking as data: rows, costs, verdicts, the proposed scene; its sentences and table."""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from enum import StrEnum
from itertools import chain
from operator import attrgetter, sub
from typing import TYPE_CHECKING, Any

from codegen.object_display import html_of, html_table
from codegen.presentation import new_table, shortened
from codegen.readers.calls import checked_class
from runtime.results.samples import plain
from runtime.studies.harness import titled

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.table import Table

_LONGEST_REASON = 200  # characters


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
    value: float | None  # the quantity; None where there is none
    change: float | None  # from the full scene, in the quantity's unit
    relative: float | None  # |change| over the quantity's size
    doubt: float  # uncertainty of the change, in the quantity's unit
    costs: Costs | None  # of the run; None where it failed
    time_share: float | None  # of the full run's time that is saved; negative where it is longer
    verdict: Verdict
    reason: str = ""  # why it is needed or impossible, in a sentence

    @property
    def title(self) -> str:
        """``gas``, or ``rod as link``."""
        return self.name if self.word == "none" else f"{self.name} as {self.word}"


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
        return titled("effect", {row.title: row for row in self.rows}, title)

    def facts(self) -> dict[str, Any]:
        """All fields, as JSON; a number that is not finite is null."""
        return dict(plain(asdict(self)))

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

    def __repr__(self) -> str:
        """The quantity, and a sentence an effect."""
        return "\n  ".join((self.title, *sentences(self)))

    def _repr_html_(self) -> str:
        """The same with its table, for notebooks."""
        return html_of(repr(self), html_table(HEAD, chain(*table_sections(self))))


HEAD = ("without", "change", "relative", "acc.", "all", "steps", "events", "time", "verdict")
CAPTION = (
    "acc., all: operations of the kernel accelerations and of all kernels; the first row is the "
    "full scene, the others the saving"
)
_COUNTS = attrgetter("accelerations", "operations", "steps", "events")


def ranking_table(ranking: Matters) -> "Table":
    """The table for a terminal."""
    return new_table(ranking.title, CAPTION, HEAD, *table_sections(ranking), least=9)


def table_sections(ranking: Matters) -> Iterator[list[tuple[object, ...]]]:
    """The full scene; the change and the saving without each effect; the same of the proposal."""
    full, proposal = ranking.costs, ranking.proposal
    yield [("nothing", "", "", *_COUNTS(full), f"{1e3 * full.seconds:.3g} ms", "")]
    yield [(row.title, *_row_cells(full, row), row.verdict) for row in ranking.rows]
    if proposal is not None and proposal.left_out:
        change = f"{proposal.value - ranking.value:+.3g}", percent(proposal.relative)
        savings = _savings(full, proposal.costs, proposal.time_share)
        yield [("proposed", *change, *savings, "within error")]


def _row_cells(full: Costs, row: Row) -> tuple[object, ...]:
    """Change and savings; empty where there is no run."""
    if row.change is None or row.costs is None or row.time_share is None:
        return ("",) * 7
    change = f"{row.change:+.3g}", percent(row.relative)
    if row.verdict is Verdict.NONE_SEEN:
        change = f"< {row.doubt:.1g}", ""
    return (*change, *_savings(full, row.costs, row.time_share))


def _savings(full: Costs, costs: Costs, share: float) -> tuple[object, ...]:
    return (*map(sub, _COUNTS(full), _COUNTS(costs)), f"{share:.0%}")


def sentences(ranking: Matters) -> Iterator[str]:
    """Uncertainty, influence and cost of each effect, the proposal, notes."""
    share = f" ({ranking.doubt / ranking.size:.1e} of its size)" if ranking.size else ""
    doubt = f"{ranking.doubt:.1e} {ranking.unit}".rstrip()
    yield f"{ranking.quantity} is known to {doubt}{share}."
    for row in ranking.rows:
        yield _sentence(ranking, row)
    if ranking.proposal is not None:
        yield from _proposal(ranking, ranking.proposal)
    yield from ranking.notes


def _sentence(ranking: Matters, row: Row) -> str:
    if row.change is None:
        return f"{row.title} is {row.verdict}: {shortened(row.reason, _LONGEST_REASON)}"
    share = row.time_share or 0.0
    if row.verdict is Verdict.NONE_SEEN:
        limit = percent(row.doubt / ranking.size) if ranking.size else f"{row.doubt:.1e}"
        effect = f"changes {ranking.quantity} by less than its uncertainty ({limit})"
    else:
        effect = f"changes {ranking.quantity} by {percent(row.relative)}"
    if row.word != "none":
        return f"{row.title} {effect} and {_saving(share)}"
    if share >= 0.0:
        return f"{row.title} {effect} and costs {share:.0%} of the time"
    return f"{row.title} {effect}; without it the run takes {-share:.0%} more time"


def _proposal(ranking: Matters, proposal: Proposal) -> Iterator[str]:
    for titles, relative in proposal.tried:
        if titles != proposal.left_out:
            fate = "does not work" if relative is None else f"changes it by {percent(relative)}"
            yield f"together, {', '.join(titles)}: {fate}, beyond {ranking.error:g}"
    for title in proposal.put_back:
        yield f"{title} is negligible alone but not together with the others, so it is put back"
    if not proposal.left_out:
        yield f"nothing can be left out within an error of {ranking.error:g}"
        return
    yield (
        f"proposed for an error of {ranking.error:g}: {proposal.spelled}; when run, it changes "
        f"{ranking.quantity} by {percent(proposal.relative)} (known to "
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
