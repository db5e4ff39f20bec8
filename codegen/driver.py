"""The compiler's driver: from a model file to a generated module for each scene.

read      model file            → Model                   (codegen.reading.model_file)
check     Model, Scene          → problems, all at once   (codegen.check.declaration)
derive    Model, Scene          → Equations               (codegen.derive)
lower     Equations             → outline: constraints    (codegen.lower)
examine   outline               → redundant constraints, and rows for them
                                     (codegen.check.kinematics, codegen.check.shared_rows)
lower     outline, rows         → Lowered program         (codegen.lower)
emit      Lowered               → text                    (codegen.emit)
accompany Lowered               → text of derivatives, of reduced equations
                                     (codegen.generated_files.companions), if asked for
write     text                  → file, atomically        (codegen.generated_files.generated_file)
compile   file                  → machine code, kept on the disk (codegen.machine_code)
assemble  file                  → notes on the start of the scene (codegen.assembled_start)
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any, get_args

import codegen
from codegen.assembled_start import assembled_module
from codegen.check.kinematics import Findings, examine
from codegen.check.shared_rows import shared_rows
from codegen.declare.returned_values import memoize_methods
from codegen.declare.scene import Scene
from codegen.derive.equations import Equations, derive
from codegen.emit.module import Unroll, module_text, operation_table
from codegen.errors import InputError, LinkwrightError, ModelError
from codegen.files.build_records import write_record
from codegen.files.generated_modules import read_generated, unroll_of
from codegen.garbage_collection import collection_paused
from codegen.generated_files.companions import COMPANIONS
from codegen.generated_files.generated_file import (
    BuildReport,
    Clock,
    FileReport,
    Progress,
    SceneReport,
    compile_modules,
)
from codegen.generated_files.provenance import default_folder, generated_path, origin, record
from codegen.lower.lowered_scene import Lowered, lower, outline
from codegen.model import Model
from codegen.readers import arguments as readers
from codegen.readers.calls import unreadable
from codegen.reading.model_file import ModelFile, read_model
from codegen.reading.scene_selection import valid_scenes, with_settings, without_overridden

GENERATOR = f"linkwright {codegen.__version__}"


@memoize_methods
@readers.reads(
    model=readers.model, scene=readers.optional(readers.scenes),
    out=readers.optional(readers.path), settings=readers.optional(readers.values('{"J1": 900.0}')),
    progress=readers.reporter, outputs=readers.flag,
    unroll=readers.optional(readers.word(*get_args(Unroll))),
    **dict.fromkeys(("tangents", "reduced", "picture", "check", "compile"), readers.flag),
)  # fmt: skip
def build(
    model: str | Path | Model, scene: str | Scene | Sequence[str | Scene] | None = None,
    out: str | Path | None = None, *, settings: Mapping[str, float | str] | None = None,
    tangents: bool = False, reduced: bool = False, picture: bool = False, outputs: bool = False,
    check: bool = False, compile: bool = True,  # noqa: A002 (what it does)
    unroll: Unroll | None = "auto",
    progress: Progress = lambda message: None,
) -> BuildReport:  # fmt: skip
    """Generate and compile the kernels of a model's scenes.

    Parameters
    ----------
    model
        Path of a model file, a bare name for ``models/NAME.py``, or a `Model`.
    scene
        One or several, by name or from `Scene.without` and `Scene.with_`; by default all.
    out
        Folder for the generated files; by default ``generated/`` of the library for the
        library's models, else of the current directory.
    settings
        Parameter → default value in this build; the files get names of their own.
    tangents
        Also generate the exact derivatives that implicit methods need, of every scene with masses.
    reduced
        Also generate the equations in reduced coordinates, of every scene for dynamics. Existing
        companion modules are updated in any case.
    picture
        Also generate the module that draws the mechanism: the geometry of its bodies and elements.
    outputs
        Also generate the companion module with all outputs, which a result computes on demand.
    check
        Write nothing; report the files that are missing or out of date.
    compile
        Compile now, so that the first run finds machine code in the cache.
    unroll
        Whether kernels are written out, operation by operation: ``"always"``; ``"never"``, so that
        repeats become loops over tables of indices; or ``"auto"``, so that long kernels have such
        loops. None: as in the last build of a scene.
    progress
        Receives a line at the beginning of every stage; an exception that it raises is passed on.

    Returns
    -------
    BuildReport
        One `SceneReport` a scene, and the stale files of a check.

    Raises
    ------
    InputError
        If the file, the model or a scene is wrong, with all problems at once; or if a scene can
        have no derivatives or reduced equations although they are requested.
    """
    requested = {"tangents": tangents, "reduced": reduced, "picture": picture, "outputs": outputs}
    return _build(model, scene, out, settings or {}, requested, check, compile, progress, unroll)


@collection_paused()
def _build(
    model: str | Path | Model, scene: str | Scene | Sequence[str | Scene] | None,
    out: str | Path | None, given: Mapping[str, float | str], requested: Mapping[str, bool],
    check: bool, compiled: bool, progress: Progress, unroll: Unroll | None,
) -> BuildReport:  # fmt: skip
    """All stages, from the file that is read to the machine code."""
    progress("reading the model")
    started = perf_counter()
    file = read_model(model)
    declared = with_settings(file.model, given)
    settings = {name: declared.parameters[name].value for name in given}
    reading = perf_counter() - started
    scenes = [
        replace(without_overridden(s, settings), owner=declared)
        for s in valid_scenes(declared, scene)
    ]
    folder = Path(out) if out is not None else default_folder(file)
    prepared = []
    for chosen in scenes:
        clock = Clock({"read": reading}, progress, f"{declared.name}, scene {chosen.name}")
        try:
            prepared.append((*translate(declared, chosen, clock), clock))
        except ModelError as error:
            if scene is not None or not chosen.follows:
                raise
            progress(f"{clock.title}: left out, as no run may come there. {error}")
    for kind in COMPANIONS:
        if requested[kind.name]:
            kind.refuse(declared.name, [e for e, *_ in prepared], named=scene is not None)
    written = [
        _emit(file, folder, settings, requested, unroll, *translated) for translated in prepared
    ]
    every = [report for files in written for report in files]
    for report in every:
        report.bring_up_to_date(check)
        if not check:
            write_record(report.path, record(file, declared, report.digest))
    if compiled and not check:
        progress(f"{declared.name}: compile")
        times = compile_modules([report.path for report in every])
        for report, seconds in zip(every, times, strict=True):
            report.seconds["compile"] = seconds
        for report in every:
            if isinstance(report, SceneReport):
                _report_start(report)
    stale = tuple(report.path for report in every if check and report.changed)
    return BuildReport(tuple(one for one in every if isinstance(one, SceneReport)), stale)


def _report_start(report: SceneReport) -> None:
    """Report why a scene that was compiled does not assemble, or how far from its guesses."""
    try:
        start = assembled_module(report.path, report.text)
    except InputError as error:
        report.problem = str(error)
    else:
        report.notes += (start.note,) if start.note else ()


def _emit(
    file: ModelFile, folder: Path, settings: Mapping[str, float], requested: Mapping[str, bool],
    unroll: Unroll | None, equations: Equations, lowered: Lowered, findings: Findings, clock: Clock,
) -> list[FileReport]:  # fmt: skip
    """The file of a scene, then those companions that are requested or exist."""
    path = generated_path(folder, file.stem, equations, settings)
    how: Any = unroll or (unroll_of(read_generated(path)) if path.is_file() else "auto")
    with clock("emit"):
        provenance = origin(GENERATOR, file, equations, path, settings, unroll=how)
        text = module_text(lowered, provenance)
    scene = SceneReport(
        path=path, text=text, operations=dict(operation_table(lowered.program)),
        seconds=clock.seconds, model=equations.model, scene=equations.scene.name,
        bodies=equations.bodies, coordinates=findings.coordinates,
        constraints=findings.constraints, degrees_of_freedom=findings.degrees_of_freedom,
        strategy=lowered.strategy, notes=findings.notes,
        states=tuple(state.name for state in equations.states),
        effects=tuple(e.name for e in equations.effects),
        left_out=tuple(name for name, _ in equations.left_out),
    )  # fmt: skip
    files: list[FileReport] = [scene]
    for kind in COMPANIONS:
        if kind.is_due(equations, path, requested[kind.name]):
            provenance = origin(GENERATOR, file, equations, path, settings, f" --{kind.name}", how)
            companion = kind.file(lowered, provenance, scene, clock)
            setattr(scene, kind.name, companion)
            files.append(companion)
    return files


def translate(model: Model, scene: Scene, clock: Clock) -> tuple[Equations, Lowered, Findings]:
    """Derive, examine and lower one scene."""
    try:
        with clock("derive"):
            equations = derive(model, scene)
        with clock("lower"):
            drawn = outline(equations)
        with clock("examine"):
            findings = examine(model, equations, drawn)
            if findings.problems:
                raise ModelError(findings.problems)
            shared = shared_rows(drawn, findings.dependent) if findings.dependent else ()
        with clock("lower"):
            lowered = lower(equations, shared, drawn.scene)
    except LinkwrightError:
        raise
    except Exception as error:
        *_, stage = clock.seconds
        what = f"scene '{scene.name}', at the stage {stage}: {unreadable(error)}"
        raise ModelError(what) from error
    return equations, lowered, findings
