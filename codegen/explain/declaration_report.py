"""The report on a declaration: all that is wrong; or else its freedoms, constraints and start.

The stages of a build are gone through up to the emission of kernels. Of these, the ones that
assembly takes are compiled.
"""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from codegen.assembled_start import assembled_start
from codegen.check.declaration import check_model
from codegen.check.four_bars import four_bars
from codegen.check.kinematics import Findings, joints_at_one_point, one_joint_bodies
from codegen.check.scene import check_scene
from codegen.derive.equations import Equations
from codegen.driver import translate
from codegen.errors import InputError, LinkwrightError
from codegen.generated_files.generated_file import Clock, Progress
from codegen.lower.lowered_scene import Lowered
from codegen.model import Model
from codegen.model.base import TRACKED
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes, with_settings, without_overridden


@dataclass(frozen=True)
class Moved:
    """A coordinate that closing the joints moves: its guess, the value reached, the unit."""

    name: str
    guess: float
    reached: float
    unit: str


@dataclass(frozen=True)
class SceneFacts:
    """What a sound scene amounts to."""

    scene: str
    analysis: str
    bodies: tuple[str, ...]
    coordinates: int
    constraints: int
    degrees_of_freedom: int  # redundant constraints take no freedom away
    mobility: tuple[int, int]  # of joints without drivers: by Grübler's count, by rank
    four_bars: tuple[str, ...]  # Grashof's class of each loop of four links
    drivers: tuple[str, ...]
    notes: tuple[str, ...]  # sentences about redundant constraints, and a start far from its guess
    gap: float | None  # the largest residual at the start, m or rad; None where joints are open
    moved: tuple[Moved, ...]  # at the start, the largest change first
    problem: str  # why the scene does not assemble
    left_out: tuple[str, ...]  # elements that have no share in the scene
    unused_parameters: tuple[str, ...]
    unused_labels: tuple[str, ...]  # of conditions that no law of the scene contains
    one_joint: dict[str, str]  # body that one joint alone holds → the joint


@dataclass(frozen=True)
class DeclarationReport:
    """Problems of a declaration, facts of its sound scenes, and what no scene uses."""

    model: str
    problems: tuple[str, ...]
    scenes: tuple[SceneFacts, ...]
    # "bodies", "effects", "drivers", "parameters" and "labels" → names that no scene uses; empty
    # where one scene alone was checked or where there is a problem
    unused: dict[str, tuple[str, ...]]

    def facts(self) -> dict[str, Any]:
        """The JSON object of the report."""
        ok = not self.problems
        return {"ok": ok, "status": 0 if ok else 2, **asdict(self)}


def check_declaration(
    model: str | Path | Model, scene: str | None = None, *,
    settings: Mapping[str, float | str] | None = None, progress: Progress = lambda message: None,
) -> DeclarationReport:  # fmt: skip
    """Check a model and its scenes, or one of them.

    Parameters
    ----------
    model, scene, settings, progress
        As for `codegen.build`.

    Raises
    ------
    InputError
        If the model file cannot be read, or the scene or a parameter of `settings` is not there.
        Problems of the declaration itself are in the report.
    """
    progress("reading the model")
    declared = with_settings(read_model(model).model, settings or {})
    if scene is not None and scene not in declared.scenes:
        valid_scenes(declared, scene)  # SceneError, or the problems of the model
    problems = check_model(declared)
    if problems:
        names = [scene] if scene is not None else [*declared.scenes]
        more = (_problems_of_scene(declared, name) for name in names)
        problems += [p for found in more for p in found]
        return DeclarationReport(declared.name, tuple(dict.fromkeys(problems)), (), {})
    scenes: list[SceneFacts] = []
    given: list[str | None] = [*declared.scenes] if scene is None else [scene]
    for name in given or [None]:
        try:
            for valid in valid_scenes(declared, name):
                chosen = without_overridden(valid, settings or {})
                clock = Clock({}, progress, f"{declared.name}, scene {chosen.name}")
                equations, lowered, findings = translate(declared, chosen, clock)
                progress(f"{declared.name}, scene {chosen.name}: assemble")
                scenes.append(_facts(declared, equations, lowered, findings))
                problems += filter(None, (scenes[-1].problem,))
        except LinkwrightError as error:
            problems += error.problems
    if any(facts.problem for facts in scenes):
        problems = [*joints_at_one_point(declared), *problems]
    complete = scene is None and not problems
    unused = _unused(declared, scenes) if complete else {}
    return DeclarationReport(declared.name, tuple(dict.fromkeys(problems)), tuple(scenes), unused)


def _problems_of_scene(model: Model, name: str) -> list[str]:
    """Problems of a scene of an unsound model, where they can be found at all."""
    scene = model.scenes[name]
    found = [*scene.problems]
    with suppress(Exception):  # for a reason that is among the model's own problems
        found += check_scene(model, scene)
    return found


def _facts(model: Model, equations: Equations, lowered: Lowered, found: Findings) -> SceneFacts:
    rows = equations.left_out  # a point that bears the name of a joint is not meant
    left_out = tuple(n for n, kind in rows if kind != TRACKED or n not in model.joints)
    texts = "\n".join(switch.text for switch in equations.switches)
    gap, moved, notes, problem = None, list[Moved](), found.notes, ""
    driven = sum(len(c.statement.rows) for c in equations.constraints if c.driver)
    by_rank = found.degrees_of_freedom + driven
    try:
        start = assembled_start(lowered)
    except InputError as error:
        problem = str(error)
    else:
        gap = max(start.residual.values(), default=0.0)
        notes += (start.note,) if start.note else ()
        places = {row.name for row in start.coordinates}
        moved = [
            Moved(*row)
            for row in sorted(start.moved, key=lambda row: -abs(row.by))
            if row.name in places
        ]
    return SceneFacts(
        equations.scene.name, equations.scene.analysis, equations.bodies, found.coordinates,
        found.constraints, found.degrees_of_freedom, (by_rank - len(found.dependent), by_rank),
        four_bars(with_settings(model, dict(equations.scene.parameters)), left_out),
        tuple(c.name for c in equations.constraints if c.driver), notes,
        gap, tuple(moved), problem, left_out, equations.unused,
        tuple(words for _, words in equations.labels if words.partition(" / ")[0] not in texts),
        {one: joint for one, joint in one_joint_bodies(model, left_out) if one in equations.bodies},
    )  # fmt: skip


def _unused(model: Model, scenes: Sequence[SceneFacts]) -> dict[str, tuple[str, ...]]:
    """What no scene uses, in the order of its declaration."""
    left_out = [scene.left_out for scene in scenes]
    of_kinds: dict[str, tuple[Iterable[str], Sequence[Iterable[str]]]] = {
        "bodies": (model.bodies, [set(model.bodies) - {*scene.bodies} for scene in scenes]),
        "joints": (model.joints, left_out),
        # Pages draw the paths of points also where no scene has them as outputs.
        "effects": ((n for n, e in model.effects.items() if e.kind != TRACKED), left_out),
        "drivers": (model.drivers, left_out),
        "parameters": (model.parameters, [scene.unused_parameters for scene in scenes]),
        "labels": (model.labels.values(), [scene.unused_labels for scene in scenes]),
    }
    found = {
        kind: tuple(name for name in names if all(name in absent for absent in of_scenes))
        for kind, (names, of_scenes) in of_kinds.items()
    }
    return {kind: names for kind, names in found.items() if names and scenes}
