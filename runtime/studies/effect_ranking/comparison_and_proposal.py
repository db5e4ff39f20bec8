"""Scenes compared with the full one, and the cheapest scene within an error.

The proposal leaves out all effects that are negligible alone, and is run before it is made.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from codegen.errors import InputError
from runtime.studies.effect_ranking.quantity import Quantity
from runtime.studies.effect_ranking.ranking import Proposal, Row, Verdict
from runtime.studies.effect_ranking.scene_trial import Plan, Trial, TrialError, run_trial
from runtime.studies.scene_loading import LEFT_OUT, Source

if TYPE_CHECKING:
    from codegen import Scene
    from codegen.one_change_scenes import Variant

STILL = 1e-9  # accuracy: share of the full scene's motion below which nothing moves


@dataclass(frozen=True)
class Comparison:
    """Compares scenes with the full one, that of the source."""

    source: Source
    plan: Plan
    quantity: Quantity
    full: Trial  # of the full scene
    error: float | None  # the relative change that is permitted
    progress: Callable[[str], None]  # receives a line before every step that takes time

    @property
    def size(self) -> float:
        """Divisor of relative changes: see `Matters`."""
        value = abs(self.full.quantity.value)
        return value if value > 10.0 * self.full.doubt else max(self.full.quantity.scale, value)

    def trial(self, scene: "Scene") -> Trial:
        """Run a variant; raises TrialError where it does not work as the full scene does."""
        self.progress(f"{self.source.model.name}/{scene.name}")
        try:
            trial = run_trial(self.source.variant(scene), self.plan, self.quantity)
        except InputError as problem:
            raise TrialError("; ".join(problem.problems)) from problem
        reach, freedom = self.full.reach, self.full.freedom
        if trial.freedom != freedom:
            raise TrialError(
                f"it has {trial.freedom} degrees of freedom, where the full scene has {freedom}"
            )
        common = [name for name in trial.reach if reach.get(name, 0.0) > 0.0]
        if common and all(trial.reach[name] <= STILL * reach[name] for name in common):
            raise TrialError("nothing moves without it")
        return trial

    def row(self, change: "Variant") -> tuple[Row, Trial | None]:
        """The verdict on one change, and its trial if it ran."""
        scene = change.of(self.source.scene)
        about = (change.name, change.kind, change.word, scene.name)
        try:
            trial = self.trial(scene)
        except TrialError as error:
            verdict = Verdict.NEEDED if change.word == LEFT_OUT else Verdict.IMPOSSIBLE
            return Row(*about, None, None, None, 0.0, None, None, verdict, str(error)), None
        delta, doubt, relative = self.change(trial)
        verdict = Verdict.NEGLIGIBLE if self.permits(delta, doubt) else Verdict.MATTERS
        if abs(delta) <= doubt:
            verdict = Verdict.NONE_SEEN
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
    comparison: Comparison, rows: list[tuple[Row, "Variant"]]
) -> tuple[Proposal, Trial]:
    """The scene without all that is negligible, or as much of it as the error permits together.

    While the scene is beyond the error, the effect that changes the quantity most is put back and
    the scene run again; the proposed scene has therefore been run.
    """
    full = comparison.source.scene
    left_out = _negligible(comparison, rows)
    put_back: list[str] = []
    tried: list[tuple[tuple[str, ...], float | None]] = []
    scene, trial = full, comparison.full
    while left_out:
        titles = tuple(row.title for row, _ in left_out)
        for _, change in left_out:
            scene = change.of(scene)
        comparison.progress(f"checking the scene without {', '.join(titles)}")
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
        scene, trial = full, comparison.full
    _, doubt, relative = comparison.change(trial)
    proposal = Proposal(
        left_out=tuple(row.title for row, _ in left_out), put_back=tuple(put_back),
        scene=scene.name, spelled=scene.expression, value=trial.quantity.value, relative=relative,
        doubt=comparison.relative(doubt), costs=trial.costs, time_share=math.nan,
        tried=tuple(tried),
    )  # fmt: skip
    return proposal, trial


def _negligible(
    comparison: Comparison, rows: list[tuple[Row, "Variant"]]
) -> list[tuple[Row, "Variant"]]:
    """Changes that the error permits alone and that make a run cheaper; the least first.

    An element is left out if that is permitted; else it is taken in the fidelity that changes the
    quantity least, if the run then takes less work.
    """

    def size(pair: tuple[Row, "Variant"]) -> tuple[float, str]:
        return pair[0].relative or 0.0, pair[0].title

    chosen: dict[str, tuple[Row, Variant]] = {}
    for row, change in sorted(rows, key=lambda pair: (pair[0].word != LEFT_OUT, size(pair))):
        if row.costs is None or row.verdict not in {Verdict.NEGLIGIBLE, Verdict.NONE_SEEN}:
            continue
        cheaper = row.word == LEFT_OUT or row.costs.work < comparison.full.costs.work
        if cheaper and comparison.permits(row.change or 0.0, row.doubt):
            chosen.setdefault(row.name, (row, change))
    return sorted(chosen.values(), key=size)
