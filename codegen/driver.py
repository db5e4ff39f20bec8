"""The driver: a model file in, a generated module a scene out.

read      model file            → Model                   (codegen.model_file)
check     Model, Scene          → problems, all at once   (codegen.check.declaration)
derive    Model, Scene          → Equations               (codegen.derive)
lower     Equations             → Lowered program         (codegen.lower)
examine   Equations, Lowered    → redundant constraints   (codegen.check.redundancy)
emit      Lowered               → text                    (codegen.emit)
accompany Lowered               → text of derivatives, of reduced equations
                                     (codegen.generated_files.companions), if asked for
write     text                  → file, atomically        (codegen.generated_files.atomic_write)
compile   file                  → machine code in numba's cache
"""

from collections.abc import Mapping, Sequence
from copy import copy
from pathlib import Path
from time import perf_counter

import sympy

import codegen
from codegen.check.declaration import check_model, check_scene
from codegen.check.redundancy import Findings, examine
from codegen.declare.names import nearest
from codegen.declare.scene import Scene
from codegen.derive.equations import Equations, derive
from codegen.emit.module import Origin, module_text
from codegen.errors import ModelError, SceneError
from codegen.generated_files.atomic_write import is_current, write_if_changed
from codegen.generated_files.build_clock import Clock, File, Progress
from codegen.generated_files.build_report import BuildReport, report
from codegen.generated_files.companions import COMPANIONS
from codegen.generated_files.fingerprint import fingerprint
from codegen.generated_files.machine_code import compile_modules
from codegen.generated_files.parameter_overrides import settled, with_settings
from codegen.generated_files.paths import default_folder, file_name
from codegen.lower.kernels.scene_kernels import Lowered, lower
from codegen.model import Model
from codegen.model_file import ModelFile, read_model


def build(
    model: str | Path | Model,
    scene: str | Scene | Sequence[str | Scene] | None = None,
    out: str | Path | None = None,
    *,
    settings: Mapping[str, float] | None = None,
    tangents: bool = False,
    reduced: bool = False,
    check: bool = False,
    compile: bool = True,  # noqa: A002 (what it does)
    progress: Progress = lambda message: None,
) -> BuildReport:
    """Generate and compile the kernels of a model's scenes.

    Parameters
    ----------
    model
        Path of a model file, a bare name for ``models/NAME.py``, or a `Model`.
    scene
        One scene or several, by name or as `Scene.without` and `Scene.with_` made them; None
        builds all that are declared.
    out
        Folder for the generated files; by default ``generated/`` of the library for the
        library's models, else of the folder one works in.
    settings
        Parameter → default value in this build; the files get a name of their own.
    tangents
        Generate also the exact derivatives that implicit methods take, of every scene with
        masses.
    reduced
        Generate also the equations in reduced coordinates, of every scene for dynamics. Files of
        either kind that exist are brought up to date in any case.
    check
        Write nothing; report which files are missing or out of date.
    compile
        Compile at once, so that the first run finds machine code in the cache.
    progress
        Receives a line at the beginning of every stage.

    Raises
    ------
    InputError
        If anything is wrong with the file, the model or a scene: all problems at once; or if
        derivatives or reduced equations are asked for of a scene that has none.
    """
    progress("reading the model")
    started = perf_counter()
    file = read_model(model)
    declared = with_settings(file.model, settings or {})
    reading = perf_counter() - started
    scenes = [settled(s, settings or {}) for s in sound_scenes(declared, scene)]
    folder = Path(out) if out is not None else default_folder(file)
    prepared = []
    for chosen in scenes:
        clock = Clock({"read": reading}, progress, f"{declared.name}, scene {chosen.name}")
        prepared.append((*translate(declared, chosen, clock), clock))
    asked = {"tangents": tangents, "reduced": reduced}
    for kind in COMPANIONS:
        if asked[kind.name]:
            kind.refuse(declared.name, [e for e, *_ in prepared], named=scene is not None)
    files: list[File] = []
    for equations, lowered, _, clock in prepared:
        path = folder / file_name(file.stem, equations, settings or {})
        with clock("emit"):
            text = module_text(lowered, origin(file, equations, path, settings or {}))
        files.append(File(path, text, clock))
        for kind in COMPANIONS:
            if kind.wanted(equations, path, asked[kind.name]):
                provenance = origin(file, equations, path, settings or {}, f" --{kind.name}")
                files[-1].companions[kind.name] = kind.file(lowered, provenance, files[-1])
    every = [f for main in files for f in (main, *main.companions.values())]
    for f in every:
        f.changed = not is_current(f.path, f.text) if check else write_if_changed(f.path, f.text)
    if compile and not check:
        progress(f"{declared.name}: compile")
        for f, seconds in zip(every, compile_modules([f.path for f in every]), strict=True):
            f.clock.seconds["compile"] = seconds
    reports = (
        report(equations, lowered, findings, written)
        for (equations, lowered, findings, _), written in zip(prepared, files, strict=True)
    )
    return BuildReport(tuple(reports), tuple(f.path for f in every if check and f.changed))


def translate(model: Model, scene: Scene, clock: Clock) -> tuple[Equations, Lowered, Findings]:
    """Derive, lower and examine one scene."""
    with clock("derive"):
        equations = derive(model, scene)
    with clock("lower"):
        lowered = lower(equations)
    with clock("examine"):
        findings = examine(equations, lowered)
    if findings.problems:
        raise ModelError(findings.problems)
    return equations, lowered, findings


def sound_scenes(model: Model, names: str | Scene | Sequence[str | Scene] | None) -> list[Scene]:
    """The scenes to build, once the model and they have been checked.

    A model that declares no scene gets one, ``default``, in which everything acts.
    """
    problems = check_model(model)
    if problems:
        raise ModelError(problems)
    if not model.scenes:
        model = copy(model)
        model.scenes = {}
        model.scene("default", effects=model.effects, drivers=model.drivers)
    chosen = (
        (names,) if isinstance(names, str | Scene) else model.scenes if names is None else names
    )
    wanted = [name for name in chosen if isinstance(name, str)]
    made = [model.again(scene) for scene in chosen if isinstance(scene, Scene)]
    missing = [
        f"model '{model.name}' has no scene '{name}'; {nearest(name, model.scenes)}"
        for name in wanted
        if name not in model.scenes
    ]
    missing += [problem for scene in made for problem in scene.problems]
    if missing:
        raise SceneError(missing)
    scenes = [scene for name, scene in model.scenes.items() if name in wanted]
    scenes += [scene for scene in made if scene not in scenes]
    problems = [problem for s in scenes for problem in check_scene(model, s)]
    if problems:
        raise ModelError(problems)
    return scenes


def origin(
    file: ModelFile,
    equations: Equations,
    path: Path,
    settings: Mapping[str, float],
    more: str = "",
) -> Origin:
    """Provenance, with paths relative to the folder that holds the folder of generated files.

    Parameters
    ----------
    more
        Further options of the command that builds the file.
    """
    base = path.resolve().parent.parent
    named = [(_relative(source, base), digest) for source, digest in file.sources]
    options = "".join(f" --set {name}={value!r}" for name, value in sorted(settings.items())) + more
    made = equations.scene.root is not None  # by without() and with_(): no name that a file knows
    scene = equations.scene.spelled if made else f"'{equations.scene.name}'"
    command = f"build({file.model.name}, scene={scene})"
    if named and not made:
        command = f"python -m codegen build {named[0][0]} --scene {equations.scene.name}{options}"
    generator = f"linkwright {codegen.__version__}"
    engine = f"SymPy {sympy.__version__}"
    return Origin(generator, tuple(named), fingerprint(equations), command, engine)


def _relative(source: Path, base: Path) -> str:
    return (source.relative_to(base) if source.is_relative_to(base) else source).as_posix()
