"""The cheapest scene within an error: without all effects that are negligible alone, then run."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from runtime.studies.effect_ranking.ranking import Proposal, Row, Verdict
from runtime.studies.effect_ranking.trial_run import Trial, TrialError

if TYPE_CHECKING:
    from codegen import Scene
    from codegen.scene_variants import Variant


@dataclass
class Comparison:
    """Compares scenes with the full one.

    Attributes
    ----------
    size
        Divisor of relative changes.
    error
        The relative change that is permitted, or None.
    scene, trial
        The full scene; scene → its trial, which raises `TrialError`.
    """

    full: Trial
    size: float
    error: float | None
    scene: "Scene"
    trial: Callable[["Scene"], Trial]

    def row(self, change: "Variant") -> tuple[Row, Trial | None]:
        """The verdict on one change, and its trial if it ran."""
        scene = change.of(self.scene)
        about = (change.name, change.kind, change.word, scene.name)
        try:
            trial = self.trial(scene)
        except TrialError as error:
            verdict = Verdict.NEEDED if change.word == "none" else Verdict.IMPOSSIBLE
            return Row(*about, None, None, None, 0.0, None, None, verdict, str(error)), None
        delta, doubt, relative = self.change(trial)
        if abs(delta) <= doubt:
            verdict = Verdict.NONE_SEEN
        else:
            verdict = Verdict.NEGLIGIBLE if self.permits(delta, doubt) else Verdict.MATTERS
        value = trial.quantity.value
        return Row(*about, value, delta, relative, doubt, trial.costs, None, verdict), trial

    def change(self, trial: Trial) -> tuple[float, float, float]:
        """Change of the quantity, the uncertainty of the change, and the relative change."""
        delta = trial.quantity.value - self.full.quantity.value
        return delta, trial.doubt + self.full.doubt, self.relative(abs(delta))

    def relative(self, amount: float) -> float:
        """An amount over the quantity's size; infinite if the quantity is zero throughout."""
        return amount / self.size if self.size else (math.inf if amount else 0.0)

    def permits(self, delta: float, doubt: float) -> bool:
        """Whether the error permits a change of this uncertainty."""
        return self.error is not None and abs(delta) + doubt <= self.error * self.size


def propose_scene(
    comparison: Comparison, rows: list[tuple[Row, "Variant"]], progress: Callable[[str], None]
) -> tuple[Proposal, Trial]:
    """The scene without all that is negligible, or as much of it as the error permits together.

    While the scene is beyond the error, the effect that changes the quantity most is put back and
    the scene run again; the proposed scene has therefore been run.
    """
    left_out = _negligible(comparison, rows)
    put_back: list[str] = []
    tried: list[tuple[tuple[str, ...], float | None]] = []
    scene, trial = comparison.scene, comparison.full
    while left_out:
        titles = tuple(row.title for row, _ in left_out)
        scene = comparison.scene
        for _, change in left_out:
            scene = change.of(scene)
        progress(f"checking the scene without {', '.join(titles)}")
        try:
            trial = comparison.trial(scene)
        except TrialError:
            tried.append((titles, None))
        else:
            delta, doubt, relative = comparison.change(trial)
            tried.append((titles, relative))
            if comparison.permits(delta, doubt):
                break
        put_back.append(left_out.pop()[0].title)
        scene, trial = comparison.scene, comparison.full
    _, doubt, relative = comparison.change(trial)
    proposal = Proposal(
        left_out=tuple(row.title for row, _ in left_out),
        put_back=tuple(put_back),
        scene=scene.name,
        spelled=scene.spelled,
        value=trial.quantity.value,
        relative=relative,
        doubt=comparison.relative(doubt),
        costs=trial.costs,
        time_share=math.nan,
        tried=tuple(tried),
    )
    return proposal, trial


def _negligible(
    comparison: Comparison, rows: list[tuple[Row, "Variant"]]
) -> list[tuple[Row, "Variant"]]:
    """Changes that the error permits alone and that make a run cheaper; the least first.

    An element is left out if that is permitted; else it is taken in the fidelity that changes the
    quantity least, if the run then takes less work.
    """

    def change_of(row: Row) -> tuple[float, str]:
        return row.relative or 0.0, row.title

    chosen: dict[str, tuple[Row, Variant]] = {}
    work = comparison.full.costs.work
    for row, change in sorted(rows, key=lambda pair: (pair[1].word != "none", change_of(pair[0]))):
        if row.costs is None or row.verdict not in {Verdict.NEGLIGIBLE, Verdict.NONE_SEEN}:
            continue
        cheaper = change.word == "none" or row.costs.work < work
        if cheaper and comparison.permits(row.change or 0.0, row.doubt):
            chosen.setdefault(row.name, (row, change))
    return sorted(chosen.values(), key=lambda pair: change_of(pair[0]))
