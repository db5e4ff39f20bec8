"""The driver: a model file in, a generated module a scene out.

read      model file            → Model                   (codegen.reading.model_file)
check     Model, Scene          → problems, all at once   (codegen.check.declaration)
derive    Model, Scene          → Equations               (codegen.derive)
lower     Equations             → Lowered program         (codegen.lower)
examine   Equations, Lowered    → redundant constraints   (codegen.check.redundancy)
emit      Lowered               → text                    (codegen.emit)
accompany Lowered               → text of derivatives, of reduced equations
                                     (codegen.generated_files.companions), if asked for
write     text                  → file, atomically        (codegen.generated_files.generated_file)
compile   file                  → machine code, kept on the disk (codegen.machine_code)
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import get_args

import codegen
from codegen.check.redundancy import Findings, examine
from codegen.declare.returned_kinds import memoize_methods
from codegen.declare.scene import Scene
from codegen.derive.equations import Equations, derive
from codegen.emit.module import module_text, operation_table
from codegen.emit.unrolling import Unroll
from codegen.errors import (
    InputError,
    LinkwrightError,
    ModelError,
)
from codegen.garbage_collection import collection_paused
from codegen.generated_files.build_report import BuildReport, report
from codegen.generated_files.companions import COMPANIONS
from codegen.generated_files.generated_file import Clock, File, Progress, compile_modules
from codegen.generated_files.provenance import default_folder, file_name, origin
from codegen.lower.lowered_scene import Lowered, lower
from codegen.model import Model
from codegen.readers import arguments as readers
from codegen.readers.failures import unreadable
from codegen.readers.values import shown
from codegen.reading.model_file import ModelFile, read_model
from codegen.reading.scene_selection import valid_scenes, with_settings, without_overridden

GENERATOR = f"linkwright {codegen.__version__}"


@memoize_methods
@readers.reads(
    model=readers.model, scene=readers.optional(readers.scenes),
    out=readers.optional(readers.path), settings=readers.optional(readers.values('{"J1": 900.0}')),
    progress=readers.reporter, unroll=readers.text("give 'auto', 'always' or 'never'."),
    **dict.fromkeys(("tangents", "reduced", "picture", "check", "compile"), readers.flag),
)  # fmt: skip
def build(
    model: str | Path | Model, scene: str | Scene | Sequence[str | Scene] | None = None,
    out: str | Path | None = None, *, settings: Mapping[str, float] | None = None,
    tangents: bool = False, reduced: bool = False, picture: bool = False, check: bool = False,
    compile: bool = True,  # noqa: A002 (what it does)
    unroll: Unroll = "auto",
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
        Also generate what draws the mechanism: the geometry of its bodies and elements.
    check
        Write nothing; report the files that are missing or out of date.
    compile
        Compile now, so that the first run finds machine code in the cache.
    unroll
        Whether kernels are written out, operation by operation: ``"always"``, ``"never"``, where
        repeats become loops over tables of indices, or ``"auto"``, where long kernels do.
    progress
        Receives a line at the beginning of every stage; what it raises is passed on.

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
    requested = {"tangents": tangents, "reduced": reduced, "picture": picture}
    return _build(
        model, scene, out, settings or {}, requested, check, compile, progress, unroll
    )  # fmt: skip


@collection_paused()
def _build(
    model: str | Path | Model, scene: str | Scene | Sequence[str | Scene] | None,
    out: str | Path | None, settings: Mapping[str, float], requested: Mapping[str, bool],
    check: bool, compiled: bool, progress: Progress, unroll: Unroll,
) -> BuildReport:  # fmt: skip
    """All stages, from the file that is read to the machine code."""
    if unroll not in get_args(Unroll):
        raise InputError(f"unroll is {shown(unroll)}; give 'auto', 'always' or 'never'.")
    progress("reading the model")
    started = perf_counter()
    file = read_model(model)
    declared = with_settings(file.model, settings)
    reading = perf_counter() - started
    scenes = [without_overridden(s, settings) for s in valid_scenes(declared, scene)]
    folder = Path(out) if out is not None else default_folder(file)
    prepared = []
    for chosen in scenes:
        clock = Clock({"read": reading}, progress, f"{declared.name}, scene {chosen.name}")
        prepared.append((*translate(declared, chosen, clock), clock))
    for kind in COMPANIONS:
        if requested[kind.name]:
            kind.refuse(declared.name, [e for e, *_ in prepared], named=scene is not None)
    files = [
        _emit(file, equations, lowered, clock, folder, settings, requested, unroll)
        for equations, lowered, _, clock in prepared
    ]
    every = [f for main in files for f in (main, *main.companions.values())]
    for f in every:
        f.bring_up_to_date(check)
    if compiled and not check:
        progress(f"{declared.name}: compile")
        for f, seconds in zip(every, compile_modules([f.path for f in every]), strict=True):
            f.clock.seconds["compile"] = seconds
    reports = (
        report(equations, lowered.strategy, findings, written)
        for (equations, lowered, findings, _), written in zip(prepared, files, strict=True)
    )
    return BuildReport(tuple(reports), tuple(f.path for f in every if check and f.changed))


def _emit(
    file: ModelFile, equations: Equations, lowered: Lowered, clock: Clock, folder: Path,
    settings: Mapping[str, float], requested: Mapping[str, bool], unroll: Unroll,
) -> File:  # fmt: skip
    """The file of a scene, with those companions that are requested or exist."""
    path = folder / file_name(file.stem, equations, settings)
    with clock("emit"):
        text = module_text(
            lowered, origin(GENERATOR, file, equations, path, settings, unroll=unroll)
        )
    main = File(path, text, clock, dict(operation_table(lowered.program)))
    for kind in COMPANIONS:
        if kind.is_due(equations, path, requested[kind.name]):
            provenance = origin(
                GENERATOR, file, equations, path, settings, f" --{kind.name}", unroll
            )
            main.companions[kind.name] = kind.file(lowered, provenance, main)
    return main


def translate(model: Model, scene: Scene, clock: Clock) -> tuple[Equations, Lowered, Findings]:
    """Derive, lower and examine one scene."""
    stage = "derive"
    try:
        with clock(stage):
            equations = derive(model, scene)
        stage = "lower"
        with clock(stage):
            lowered = lower(equations)
        stage = "examine"
        with clock(stage):
            findings = examine(equations, lowered)
    except LinkwrightError:
        raise
    except Exception as error:
        raise ModelError(
            f"scene '{scene.name}', at the stage {stage}: {unreadable(error)}"
        ) from error
    if findings.problems:
        raise ModelError(findings.problems)
    return equations, lowered, findings
