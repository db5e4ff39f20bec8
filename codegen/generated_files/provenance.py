"""Provenance of a generated file: folder, name, sources, and the command that rebuilds it."""

import hashlib
from collections.abc import Mapping
from pathlib import Path

import sympy

from codegen.derive.equations import Equations
from codegen.emit.line_wrapping import literal
from codegen.emit.module import Origin, Unroll
from codegen.files.build_records import Input, Record, generator_state
from codegen.files.generated_modules import scene_path
from codegen.files.library_folders import LIBRARY, models_folder
from codegen.model import Model
from codegen.reading.model_file import ModelFile


def default_folder(file: ModelFile) -> Path:
    """The folder of a model's generated files."""
    models = models_folder()
    ours = file.path is not None and models is not None and file.path.is_relative_to(models)
    return (LIBRARY if ours else Path.cwd()) / "generated"


def generated_path(
    folder: Path, stem: str, equations: Equations, settings: Mapping[str, float]
) -> Path:
    """``model__scene.py`` after the model file, with a tail for a build with other defaults."""
    text = ",".join(f"{name}={literal(value)}" for name, value in sorted(settings.items()))
    tail = f"__{hashlib.sha256(text.encode()).hexdigest()[:8]}" if settings else ""
    return scene_path(folder, stem, equations.scene.name, tail)


def record(file: ModelFile, model: Model, digest: str) -> Record:
    """What a generated file, whose text has this SHA-256, was made from."""
    scenes = tuple(model.scenes) or ("default",)
    sources = (Input("file", str(source), value) for source, value in file.sources)
    return Record(digest, generator_state(), scenes, (*sources, *file.asked), file.unwatched)


def origin(
    generator: str, file: ModelFile, equations: Equations, path: Path,
    settings: Mapping[str, float], more: str = "", unroll: Unroll = "auto",
) -> Origin:  # fmt: skip
    """Provenance, with paths relative to the folder that holds the folder of generated files.

    `generator` is the name and version of the compiler, `more` further options of the command that
    builds the file.
    """
    base = path.resolve().parent.parent
    named = [
        ((source.relative_to(base) if source.is_relative_to(base) else source).as_posix(), digest)
        for source, digest in file.sources
    ]
    options = "".join(f" --set {name}={literal(value)}" for name, value in sorted(settings.items()))
    options += more + f" --unroll {unroll}" * (unroll != "auto")
    varied = equations.scene.root is not None  # by without() or with_(): not declared in a file
    scene = equations.scene.expression if varied else f"'{equations.scene.name}'"
    form = f", unroll='{unroll}'" if unroll != "auto" else ""
    command = f"build({file.model.name}, scene={scene}{form})"
    if named and not varied:
        command = f"python -m codegen build {named[0][0]} --scene {equations.scene.name}{options}"
    engine = f"SymPy {sympy.__version__}"
    return Origin(generator, tuple(named), fingerprint(equations), command, engine, unroll)


_SCENE = (
    *("name", "bodies", "effects", "drivers", "inactive_joints", "fidelity", "start", "guess"),
    *("parameters", "frozen", "analysis", "outputs"),
)
"""The fields of a scene that the fingerprint reads, in its order."""
_LABELS = {"inactive_joints": "opened"}  # a field's name in the fingerprint, where it differs


def fingerprint(equations: Equations) -> str:
    """SHA-256 of a scene's declaration: equal exactly when equations, numbers and names are.

    It does not depend on the order of sets.
    """
    fields = ((_LABELS.get(name, name), getattr(equations.scene, name)) for name in _SCENE)
    scene = ", ".join(f"{label}={value!r}" for label, value in fields)
    lines = [f"{equations.model} Scene({scene}) {equations.coordinates}"]
    lines += [f"parameter {p}" for p in equations.parameters]
    lines += [f"mass {m}" if i == k else f"mass {i} {k} {m}" for i, k, m in equations.mass]
    lines += [f"inertia force {k} {f}" for k, f in equations.inertia_force]
    texts = dict[int, str]()  # of what the joints of a kind share, and of symbols

    def text(shared: object) -> str:
        key = id(shared)
        known = texts[key] = texts.get(key) or str(shared)
        return known

    for constraint in equations.constraints:
        statement = constraint.statement
        bindings = sorted(f"{text(k)}={text(value)}" for k, value in statement.bindings.items())
        lines.append(f"{constraint.kind} {constraint.name} {text(statement.phi)} {bindings}")
        lines += [f"  own {row} {q}" for row, q in statement.own]
        lines.append(f"  reactions {text(constraint.terms.reactions)}")
    for effect in equations.effects:
        terms = effect.terms
        lines.append(f"{effect.kind} {effect.name} {terms.potential} {terms.loads}")
        lines += [f"  pulls {terms.pulls}"] if terms.pulls else []
        lines += [f"  flux {terms.flux}"] if terms.flux else []
        lines += [f"  friction {terms.friction}"] if terms.friction else []
        lines += [f"  hold {terms.hold}"] if terms.hold else []
        lines += [f"  reported {terms.reported}"] if terms.reported else []
        lines += [f"  measures {terms.measures}"] if terms.measures else []
    lines += [f"switch {switch.g}{switch.at_zero}" for switch in equations.switches]
    lines.append(f"left out {equations.left_out}")
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()
