"""The driver: a model file in, a generated module a scene out.

read      model file            → Model                   (codegen.modelfile)
check     Model, Scene          → problems, all at once   (codegen.check)
derive    Model, Scene          → Equations               (codegen.derive)
lower     Equations             → Lowered program         (codegen.lower)
examine   Equations, Lowered    → redundant constraints   (codegen.examine)
emit      Lowered               → text                    (codegen.emit)
differentiate  Lowered          → text of derivatives     (codegen.differentiating), if asked for
write     text                  → file, atomically        (codegen.write)
compile   file                  → machine code in numba's cache
"""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import codegen
from codegen.check import check_model, check_scene
from codegen.compiling import compile_modules
from codegen.declare.names import nearest
from codegen.declare.scene import Scene
from codegen.derive.equations import Equations, derive
from codegen.differentiating import derivatives, refuse_massless, wanted
from codegen.emit.module import Origin, module_text
from codegen.errors import ModelError, SceneError
from codegen.examine import Findings, examine
from codegen.fingerprint import fingerprint
from codegen.lower.kernels import Lowered, lower
from codegen.lower.ledger import operations
from codegen.model import Model
from codegen.modelfile import ModelFile, read_model
from codegen.placing import default_folder, file_name
from codegen.settings import settled, with_settings
from codegen.stages import Clock, File, Progress
from codegen.write import is_current, write_if_changed


@dataclass(frozen=True)
class TangentsReport:
    """The file of a scene's exact derivatives; attributes as in `SceneReport`."""

    path: Path
    changed: bool
    digest: str
    operations: dict[str, int]
    seconds: dict[str, float]


@dataclass(frozen=True)
class SceneReport:
    """What was built for one scene.

    Attributes
    ----------
    path, changed, digest
        The generated file, whether it is new, and the SHA-256 of its text.
    operations
        Kernel → arithmetic operations.
    seconds
        Stage → wall time.
    tangents
        The file of its exact derivatives, if it has one.
    notes
        What a modeller should know: constraints that are redundant near the start values.
    """

    model: str
    scene: str
    path: Path
    changed: bool
    digest: str
    bodies: tuple[str, ...]
    coordinates: int
    constraints: int
    degrees_of_freedom: int
    effects: tuple[str, ...]
    left_out: tuple[str, ...]
    strategy: str | None
    operations: dict[str, int]
    seconds: dict[str, float]
    tangents: TangentsReport | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class BuildReport:
    """What `build` did, scene by scene; `stale` lists the files that a check found out of date."""

    scenes: tuple[SceneReport, ...]
    stale: tuple[Path, ...] = ()

    @property
    def paths(self) -> tuple[Path, ...]:
        """The generated files."""
        return tuple(scene.path for scene in self.scenes)


def build(
    model: str | Path | Model,
    scene: str | Scene | Sequence[str | Scene] | None = None,
    out: str | Path | None = None,
    *,
    settings: Mapping[str, float] | None = None,
    tangents: bool = False,
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
        masses. Files of derivatives that exist are brought up to date in any case.
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
        derivatives are asked for of a scene without masses.
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
    if tangents:
        massive = {e.scene.name: bool(e.masses) for e, *_ in prepared}
        refuse_massless(declared.name, massive, named=scene is not None)
    files: list[File] = []
    for equations, lowered, _, clock in prepared:
        path = folder / file_name(file.stem, equations, settings or {})
        with clock("emit"):
            text = module_text(lowered, origin(file, equations, path, settings or {}))
        files.append(File(path, text, clock))
        if wanted(equations, path, tangents):
            provenance = origin(file, equations, path, settings or {}, " --tangents")
            files[-1].tangents = derivatives(lowered, provenance, files[-1])
    every = [f for main in files for f in (main, main.tangents) if f]
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
    return Origin(generator, tuple(named), fingerprint(equations), command)


def _relative(source: Path, base: Path) -> str:
    return (source.relative_to(base) if source.is_relative_to(base) else source).as_posix()


def report(equations: Equations, lowered: Lowered, findings: Findings, file: File) -> SceneReport:
    """Gather what a person wants to know about a build."""
    n = len(equations.coordinates)
    m = sum(len(c.statement.rows) for c in equations.constraints)
    program = lowered.program
    return SceneReport(
        equations.model,
        equations.scene.name,
        file.path,
        file.changed,
        file.digest,
        equations.bodies,
        n,
        m,
        n - findings.independent,
        tuple(e.name for e in equations.effects),
        tuple(name for name, _ in equations.left_out),
        lowered.strategy,
        {k.name: operations(program, k) for k in program.kernels},
        file.clock.seconds,
        _tangents_report(file.tangents) if file.tangents else None,
        findings.notes,
    )


def _tangents_report(file: File) -> TangentsReport:
    seconds = file.clock.seconds
    return TangentsReport(file.path, file.changed, file.digest, file.operations, seconds)
