"""An effect ranking on a terminal: a row per effect, then sentences."""

import math
from collections.abc import Iterator

from rich.table import Table

from runtime.show.table_formatting import new_table, shortened
from runtime.studies.effect_ranking.ranking import Costs, Matters, Proposal, Row, Verdict

_LONGEST_REASON = 200  # characters


def table(ranking: Matters) -> Table:
    """The full scene, then the change and the saving without each effect."""
    full, value = ranking.costs, f"{ranking.value:.7g} {ranking.unit}".rstrip()
    title = f"{ranking.model}/{ranking.scene}, {ranking.analysis}: {ranking.quantity} = {value}"
    caption = (
        "acc., all: operations of the kernel accelerations and of all kernels; the first row is "
        "the full scene, the others the saving"
    )
    columns = ("change", "relative", "acc.", "all", "time", "steps", "events")
    rows = new_table(title, caption, "without", columns, 9)
    rows.add_column("verdict", no_wrap=True)
    accelerations, operations, steps, events = map(str, _counts(full))
    time = f"{1e3 * full.seconds:.3g} ms"
    rows.add_row("nothing", "", "", accelerations, operations, time, steps, events, "")
    rows.add_section()
    for row in ranking.rows:
        savings = _savings(full, row.costs, row.time_share)
        rows.add_row(row.title, *_change(row), *savings, str(row.verdict))
    proposal = ranking.proposal
    if proposal is not None and proposal.left_out:
        rows.add_section()
        change = f"{proposal.value - ranking.value:+.3g}"
        savings = _savings(full, proposal.costs, proposal.time_share)
        rows.add_row("proposed", change, _percent(proposal.relative), *savings, "within error")
    return rows


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
        limit = _percent(row.doubt / ranking.size) if ranking.size else f"{row.doubt:.1e}"
        effect = f"changes {ranking.quantity} by less than its uncertainty ({limit})"
    else:
        effect = f"changes {ranking.quantity} by {_percent(row.relative)}"
    if row.word != "none":
        return f"{row.title} {effect} and {_saving(share)}"
    if share >= 0.0:
        return f"{row.title} {effect} and costs {share:.0%} of the time"
    return f"{row.title} {effect}; without it the run takes {-share:.0%} more time"


def _proposal(ranking: Matters, proposal: Proposal) -> Iterator[str]:
    for titles, relative in proposal.tried:
        if titles != proposal.left_out:
            fate = "does not work" if relative is None else f"changes it by {_percent(relative)}"
            yield f"together, {', '.join(titles)}: {fate}, beyond {ranking.error:g}"
    for title in proposal.put_back:
        yield f"{title} is negligible alone but not together with the others, so it is put back"
    if not proposal.left_out:
        yield f"nothing can be left out within an error of {ranking.error:g}"
        return
    yield (
        f"proposed for an error of {ranking.error:g}: {proposal.spelled}; when run, it changes "
        f"{ranking.quantity} by {_percent(proposal.relative)} (known to "
        f"{_percent(proposal.doubt)}) and {_saving(proposal.time_share)}"
    )


def _saving(share: float) -> str:
    return f"saves {share:.0%} of the time" if share >= 0 else f"takes {-share:.0%} more time"


def _change(row: Row) -> tuple[str, str]:
    if row.change is None:
        return "", ""
    if row.verdict is Verdict.NONE_SEEN:
        return f"< {row.doubt:.1g}", ""
    return f"{row.change:+.3g}", _percent(row.relative)


def _counts(costs: Costs) -> tuple[int, int, int, int]:
    return costs.accelerations, costs.operations, costs.steps, costs.events


def _savings(full: Costs, costs: Costs | None, share: float | None) -> tuple[str, ...]:
    if costs is None:
        return ("",) * 5
    saved = [str(all_ - rest) for all_, rest in zip(_counts(full), _counts(costs), strict=True)]
    return (*saved[:2], "" if share is None else f"{share:.0%}", *saved[2:])


def _percent(share: float | None) -> str:
    if share is None:
        return ""
    if not math.isfinite(share):
        return "∞"
    return f"{100 * share:.2g} %" if share < 1.0 else f"{100 * share:.0f} %"
