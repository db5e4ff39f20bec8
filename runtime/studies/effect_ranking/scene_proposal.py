"""The cheapest scene within an error: all that is negligible alone, then checked by running it."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from runtime.studies.effect_ranking.ranking import Proposal, Row, Verdict
from runtime.studies.effect_ranking.trial_run import LostError, Trial

if TYPE_CHECKING:
    from codegen import Scene
    from codegen.scene_variants import Variant


@dataclass
class Judge:
    """Compares scenes with the full one.

    Attributes
    ----------
    size
        What changes are relative to.
    error
        The relative change that is permitted, or None.
    scene, trial
        The full scene; scene → its trial, which raises `LostError`.
    """

    full: Trial
    size: float
    error: float | None
    scene: "Scene"
    trial: Callable[["Scene"], Trial]

    def row(self, change: "Variant") -> tuple[Row, Trial | None]:
        """One change, judged; its trial where it has one."""
        scene = change.of(self.scene)
        about = (change.name, change.kind, change.word, scene.name)
        try:
            found = self.trial(scene)
        except LostError as lost:
            verdict = Verdict.NEEDED if change.word == "none" else Verdict.IMPOSSIBLE
            row = Row(*about, None, None, None, 0.0, None, None, verdict, str(lost))
            return row, None
        delta, doubt, relative = self.change(found)
        if abs(delta) <= doubt:
            verdict = Verdict.NONE_SEEN
        elif self.within(found):
            verdict = Verdict.NEGLIGIBLE
        else:
            verdict = Verdict.MATTERS
        value = found.reading.value
        return (
            Row(*about, value, delta, relative, doubt, found.costs, None, verdict),
            found,
        )

    def change(self, found: Trial) -> tuple[float, float, float]:
        """Change of the quantity, by how much that may be off, and the change over the size."""
        delta = found.reading.value - self.full.reading.value
        return delta, found.doubt + self.full.doubt, self.share(abs(delta))

    def share(self, amount: float) -> float:
        """An amount over the quantity's size; of a quantity that is zero throughout, infinite."""
        return amount / self.size if self.size else (math.inf if amount else 0.0)

    def within(self, found: Trial) -> bool:
        """Whether a scene keeps the quantity within the error, with all that may be off."""
        delta, doubt, _ = self.change(found)
        return self.permits(delta, doubt)

    def permits(self, delta: float, doubt: float) -> bool:
        """Whether the error permits a change that may be off by `doubt`."""
        return self.error is not None and abs(delta) + doubt <= self.error * self.size


def proposed(
    judge: Judge, rows: list[tuple[Row, "Variant"]], progress: Callable[[str], None]
) -> tuple[Proposal, Trial]:
    """The scene without all that is negligible, or as much of it as the error permits together.

    What is found to be too much together is put back, that which changes most first, until the
    scene that is proposed has been run and keeps the quantity within the error.
    """
    taken = _spared(judge, rows)
    back: list[str] = []
    tried: list[tuple[tuple[str, ...], float | None]] = []
    scene, found = judge.scene, judge.full
    while taken:
        titles = tuple(row.title for row, _ in taken)
        scene = judge.scene
        for _, change in taken:
            scene = change.of(scene)
        progress(f"checking the scene without {', '.join(titles)}")
        try:
            found = judge.trial(scene)
        except LostError:
            tried.append((titles, None))
        else:
            tried.append((titles, judge.change(found)[2]))
            if judge.within(found):
                break
        back.append(taken.pop()[0].title)
        scene, found = judge.scene, judge.full
    _, doubt, relative = judge.change(found)
    proposal = Proposal(
        tuple(row.title for row, _ in taken), tuple(back), scene.name, scene.spelled,
        found.reading.value, relative, judge.share(doubt), found.costs, math.nan, tuple(tried),
    )  # fmt: skip
    return proposal, found


def _spared(judge: Judge, rows: list[tuple[Row, "Variant"]]) -> list[tuple[Row, "Variant"]]:
    """What the error permits to change, alone, and makes a run cheaper; the least change first.

    An element is left out where it may be; else it is taken in that fidelity which changes the
    quantity least, if the run takes less work so.
    """
    chosen: dict[str, tuple[Row, Variant]] = {}
    for row, change in sorted(rows, key=lambda pair: (pair[1].word != "none", _least(pair[0]))):
        if row.costs is None or row.verdict not in {Verdict.NEGLIGIBLE, Verdict.NONE_SEEN}:
            continue
        spares = change.word == "none" or row.costs.work < judge.full.costs.work
        if judge.permits(row.change or 0.0, row.doubt) and spares:
            chosen.setdefault(row.name, (row, change))
    return sorted(chosen.values(), key=lambda pair: _least(pair[0]))


def _least(row: Row) -> tuple[float, str]:
    return (row.relative or 0.0, row.title)
