"""Which effects matter, on a terminal: a row an effect, no wider than a person reads."""

import math
from collections.abc import Iterator
from textwrap import shorten

from rich.table import Table

from runtime.show.terminal_table import padding
from runtime.studies.effect_ranking.ranking import Costs, Matters, Row, Verdict

REASONS = 200


def table(told: Matters) -> Table:
    """The full scene, then what changes, and what it spares, without each effect."""
    unit = f" {told.unit}" if told.unit else ""
    title = f"{told.model}/{told.scene}, {told.analysis}: {told.quantity} = {told.value:.7g}{unit}"
    made = Table(
        title=title,
        caption="operations, time, steps, events: in full, then what is spared of them",
        padding=padding(),
    )
    made.add_column("without", overflow="fold", ratio=1, min_width=9)
    for name in ("change", "relative", "acc.", "all", "time", "steps", "events"):
        made.add_column(name, justify="right", no_wrap=True)
    made.add_column("verdict", no_wrap=True)
    base = told.costs
    made.add_row(
        "nothing", "", "", str(base.accelerations), str(base.operations), _time(base.seconds),
        str(base.steps), str(base.events), "",
    )  # fmt: skip
    made.add_section()
    for row in told.rows:
        made.add_row(row.title, *_changes(row), *_spared(base, row), str(row.verdict))
    if told.proposal is not None and told.proposal.left_out:
        made.add_section()
        found = told.proposal
        change = found.value - told.value
        numbers = _costs(base, found.costs, found.time_share)
        made.add_row("proposed", f"{change:+.3g}", _percent(found.relative), *numbers, "holds")
    return made


def sentences(told: Matters) -> Iterator[str]:
    """What the table means, a line each: effects, what is needed and why, the proposal, notes."""
    share = f" ({told.doubt / told.size:.1e} of its size)" if told.size else ""
    unit = f" {told.unit}" if told.unit else ""
    yield f"{told.quantity} is known to {told.doubt:.1e}{unit}{share}."
    for row in told.rows:
        yield _sentence(told, row)
    if told.proposal is not None:
        yield from _proposal(told)
    yield from told.notes


def _sentence(told: Matters, row: Row) -> str:
    taken = row.word != "none"
    if row.change is None:
        return f"{row.title} is {row.verdict}: {shorten(row.reason, REASONS, placeholder=' …')}"
    share = row.time_share or 0.0
    if row.verdict is Verdict.NONE_SEEN:
        limit = _percent(row.doubt / told.size) if told.size else f"{row.doubt:.1e}"
        effect = f"changes {told.quantity} by less than can be seen ({limit})"
    else:
        effect = f"changes {told.quantity} by {_percent(row.relative)}"
    if taken:
        return f"{row.title} {effect} and {_ratio(share)}"
    if share >= 0.0:
        return f"{row.title} {effect} and costs {share:.0%} of the time"
    return f"{row.title} {effect}; without it the run takes {-share:.0%} more time"


def _proposal(told: Matters) -> Iterator[str]:
    found = told.proposal
    assert found is not None
    for titles, relative in found.tried:
        if titles != found.left_out:
            fate = "does not work" if relative is None else f"changes it by {_percent(relative)}"
            yield f"together, {', '.join(titles)}: {fate}, beyond {told.error:g}"
    for title in found.put_back:
        yield f"{title} is negligible alone and too much with the others, so it is put back"
    if not found.left_out:
        yield f"nothing can be spared within an error of {told.error:g}"
        return
    yield (
        f"proposed for an error of {told.error:g}: {found.spelled}; run in full it changes "
        f"{told.quantity} by {_percent(found.relative)} (known to {_percent(found.doubt)}) and "
        f"{_ratio(found.time_share)}"
    )


def _ratio(share: float) -> str:
    return f"spares {share:.0%} of the time" if share >= 0 else f"takes {-share:.0%} more time"


def _changes(row: Row) -> tuple[str, str]:
    if row.change is None:
        return "", ""
    if row.verdict is Verdict.NONE_SEEN:
        return f"< {row.doubt:.1g}", ""
    return f"{row.change:+.3g}", _percent(row.relative)


def _spared(base: Costs, row: Row) -> tuple[str, ...]:
    if row.costs is None:
        return ("",) * 5
    return _costs(base, row.costs, row.time_share)


def _costs(base: Costs, costs: Costs, share: float | None) -> tuple[str, ...]:
    return (
        str(base.accelerations - costs.accelerations),
        str(base.operations - costs.operations),
        "" if share is None else f"{share:.0%}",
        str(base.steps - costs.steps),
        str(base.events - costs.events),
    )


def _percent(share: float | None) -> str:
    if share is None:
        return ""
    if not math.isfinite(share):
        return "∞"
    return f"{100 * share:.2g} %" if share < 1.0 else f"{100 * share:.0f} %"


def _time(seconds: float) -> str:
    return f"{1e3 * seconds:.3g} ms"
