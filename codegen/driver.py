"""The driver: a model file in, a generated module a scene out.

read      model file            → Model                   (codegen.modelfile)
check     Model, Scene          → problems, all at once   (codegen.check)
derive    Model, Scene          → Equations               (codegen.derive)
lower     Equations             → Lowered program         (codegen.lower)
examine   Equations, Lowered    → redundant constraints   (codegen.examine)
emit      Lowered               → text                    (codegen.emit)
write     text                  → file, atomically        (codegen.write)
compile   file                  → machine code in numba's cache
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import codegen
from codegen.check import check_model, check_scene
from codegen.compiling import compile_modules
from codegen.declare.names import nearest
from codegen.declare.scene import Scene
from codegen.derive.equations import Equations, derive
from codegen.emit.module import Origin, module_text
from codegen.errors import ModelError, ParameterError, SceneError
from codegen.examine import examine
from codegen.fingerprint import fingerprint
from codegen.lower.kernels import Lowered, lower
from codegen.lower.ledger import operations
from codegen.model import Model
from codegen.modelfile import ModelFile, library_folder, read_model
from codegen.write import is_current, write_if_changed

Progress = Callable[[str], None]


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
    strategy: str
    operations: dict[str, int]
    seconds: dict[str, float]


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
    scene: str | Sequence[str] | None = None,
    out: str | Path | None = None,
    *,
    settings: Mapping[str, float] | None = None,
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
        One scene, or several; None builds all of them.
    out
        Folder for the generated files; by default ``generated/`` of the library for the
        library's models, else of the folder one works in.
    settings
        Parameter → default value in this build; the files get a name of their own.
    check
        Write nothing; report which files are missing or out of date.
    compile
        Compile at once, so that the first run finds machine code in the cache.
    progress
        Receives a line at the beginning of every stage.

    Raises
    ------
    InputError
        If anything is wrong with the file, the model or a scene: all problems at once.
    """
    progress("reading the model")
    started = perf_counter()
    file = read_model(model)
    declared = with_settings(file.model, settings or {})
    reading = perf_counter() - started
    scenes = sound_scenes(declared, scene)
    folder = Path(out) if out is not None else default_folder(file)
    prepared = []
    for chosen in scenes:
        clock = Clock({"read": reading}, progress, f"{declared.name}, scene {chosen.name}")
        prepared.append((*translate(declared, chosen, clock), clock))
    paths, changes, digests = [], [], []
    for equations, lowered, clock in prepared:
        path = folder / file_name(file.stem, equations, settings or {})
        with clock("emit"):
            text = module_text(lowered, origin(file, equations, path, settings or {}))
        changes.append(not is_current(path, text) if check else write_if_changed(path, text))
        paths.append(path)
        digests.append(hashlib.sha256(text.encode()).hexdigest())
    if compile and not check:
        progress(f"{declared.name}: compile")
        for (*_, clock), seconds in zip(prepared, compile_modules(paths), strict=True):
            clock.seconds["compile"] = seconds
    reports = (
        report(equations, lowered, path, changed, digest, clock.seconds)
        for (equations, lowered, clock), path, changed, digest in zip(
            prepared, paths, changes, digests, strict=True
        )
    )
    stale = (path for path, changed in zip(paths, changes, strict=True) if check and changed)
    return BuildReport(tuple(reports), tuple(stale))


@dataclass
class Clock:
    """Times the stages of one scene, and announces them."""

    seconds: dict[str, float]
    progress: Progress
    what: str

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Time what happens inside."""
        self.progress(f"{self.what}: {stage}")
        started = perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = perf_counter() - started


def translate(model: Model, scene: Scene, clock: Clock) -> tuple[Equations, Lowered]:
    """Derive, lower and examine one scene."""
    with clock("derive"):
        equations = derive(model, scene)
    with clock("lower"):
        lowered = lower(equations)
    with clock("examine"):
        problems = examine(equations, lowered)
    if problems:
        raise ModelError(problems)
    return equations, lowered


def sound_scenes(model: Model, names: str | Sequence[str] | None) -> list[Scene]:
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
    wanted = (names,) if isinstance(names, str) else model.scenes if names is None else names
    missing = [
        f"model '{model.name}' has no scene '{name}'; {nearest(name, model.scenes)}"
        for name in wanted
        if name not in model.scenes
    ]
    if missing:
        raise SceneError(missing)
    scenes = [scene for name, scene in model.scenes.items() if name in wanted]
    problems = [problem for s in scenes for problem in check_scene(model, s)]
    if problems:
        raise ModelError(problems)
    return scenes


def with_settings(model: Model, settings: Mapping[str, float]) -> Model:
    """A copy of the model with other defaults; every scene takes them over."""
    problems = []
    changed = copy(model)
    changed.parameters = dict(model.parameters)
    for name, value in settings.items():
        if name not in model.parameters:
            problems.append(
                f"model '{model.name}' has no parameter '{name}'; {nearest(name, model.parameters)}"
            )
        elif problem := model.parameters[name].problem(value):
            problems.append(problem)
        else:
            changed.parameters[name] = replace(model.parameters[name], value=value)
    if problems:
        raise ParameterError(problems)
    changed.scenes = {
        name: replace(
            scene, parameters=tuple(pair for pair in scene.parameters if pair[0] not in settings)
        )
        for name, scene in model.scenes.items()
    }
    return changed


def default_folder(file: ModelFile) -> Path:
    """Where the generated files of a model belong."""
    library = library_folder()
    ours = file.path is not None and file.path.is_relative_to(library / "models")
    return (library if ours else Path.cwd()) / "generated"


def file_name(stem: str, equations: Equations, settings: Mapping[str, float]) -> str:
    """``model__scene.py`` after the model file, with a tail for a build with other defaults."""
    stem = f"{stem}__{equations.scene.name}"
    if settings:
        text = ",".join(f"{name}={value!r}" for name, value in sorted(settings.items()))
        stem += f"__{hashlib.sha256(text.encode()).hexdigest()[:8]}"
    return f"{stem}.py"


def origin(
    file: ModelFile, equations: Equations, path: Path, settings: Mapping[str, float]
) -> Origin:
    """Provenance, with paths relative to the folder that holds the folder of generated files."""
    base = path.resolve().parent.parent
    named = [(_relative(source, base), digest) for source, digest in file.sources]
    options = "".join(f" --set {name}={value!r}" for name, value in sorted(settings.items()))
    command = f"build({file.model.name}, scene='{equations.scene.name}')"
    if named:
        command = f"python -m codegen build {named[0][0]} --scene {equations.scene.name}{options}"
    generator = f"linkwright {codegen.__version__}"
    return Origin(generator, tuple(named), fingerprint(equations), command)


def _relative(source: Path, base: Path) -> str:
    return (source.relative_to(base) if source.is_relative_to(base) else source).as_posix()


def report(
    equations: Equations,
    lowered: Lowered,
    path: Path,
    changed: bool,
    digest: str,
    seconds: dict[str, float],
) -> SceneReport:
    """Gather what a person wants to know about a build."""
    n = len(equations.coordinates)
    m = sum(len(c.statement.rows) for c in equations.constraints)
    program = lowered.program
    return SceneReport(
        equations.model,
        equations.scene.name,
        path,
        changed,
        digest,
        equations.bodies,
        n,
        m,
        n - m,
        tuple(e.name for e in equations.effects),
        tuple(name for name, _ in equations.left_out),
        lowered.strategy,
        {k.name: operations(program, k) for k in program.kernels},
        seconds,
    )
