"""Loading of a machine: locate its generated module, check it, and rebuild it if stale or missing.

The code generator (and with it SymPy) is imported only for a build.
"""

import os
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING
from weakref import WeakSet

from codegen.errors import InputError, note
from codegen.files.build_records import fresh_text, unchanged
from codegen.files.generated_modules import scene_path, shortened
from codegen.files.library_folders import LIBRARY as _LIBRARY
from codegen.files.library_folders import find_model_file, models_folder
from codegen.garbage_collection import collection_paused
from codegen.readers import arguments as readers
from runtime.progress_bar import compilation_shown

if TYPE_CHECKING:
    from codegen import Model, Scene
    from runtime.machine_facade import Machine
    from runtime.mechanism.mechanism import Mechanism

LOADED: "WeakSet[Mechanism]" = WeakSet()
"""The mechanisms that `load` has made, as long as anybody holds them."""


@readers.reads(
    model=readers.model, scene=readers.optional(readers.scene),
    folder=readers.optional(readers.path), generated=readers.optional(readers.path),
)  # fmt: skip
def load(
    model: "str | os.PathLike[str] | Model", scene: "str | Scene | None" = None, *,
    folder: str | os.PathLike[str] | None = None,
    generated: str | os.PathLike[str] | None = None,
) -> "Machine":  # fmt: skip
    """Load a machine; build its kernels if they are missing or older than the model.

    Parameters
    ----------
    model
        Path of a model file, or a name: `models/NAME.py` in `folder`, or else the library's model
        of that name; a name may contain folders, `"hard/pendulum"`. A `Model` declared in the
        running program is built anew.
    scene
        Name of the scene, by default the first that the model declares. Or a scene itself, as
        `without` and `with_` return it: ``model.scene("run").without("gas")``.
    folder
        The working folder, by default the current directory: it may contain `models/`, and the
        modules of a user's models are generated into its `generated/`.
    generated
        The folder of the generated modules, as `build(out=...)` names it, relative to `folder`; by
        default `generated/` in `folder`, and for a model of the library the library's own.
    """
    here = (Path(folder) if folder is not None else Path.cwd()).resolve()
    source: Path | Model
    if isinstance(model, str | os.PathLike):
        source, modules = _locate(os.fspath(model), here)
        modules = modules if generated is None else here / generated
        path, text = _fresh_module(source, modules, scene)
    else:
        source = model
        path, text = _build(model, scene, here / (generated or "generated"))
    with compilation_shown():
        from runtime.machine_facade import Machine
        from runtime.mechanism.mechanism import read_mechanism

        declared = None if isinstance(scene, str) else scene
        mechanism = read_mechanism(path, text, source, declared)
        from runtime.assembly.assemble import assemble_declared
    LOADED.add(mechanism)
    try:
        assemble_declared(mechanism)
    except InputError as error:
        note(str(error))  # other parameters or guesses may assemble
    return Machine(mechanism)


def _locate(model: str, folder: Path) -> tuple[Path, Path]:
    """Model file and the folder of its generated modules, from what the user wrote."""
    found, models, generated = (
        find_model_file(model, folder, _LIBRARY), models_folder(_LIBRARY), _LIBRARY / "generated"
    )  # fmt: skip
    of_library = models is not None and found.is_relative_to(models.resolve())
    return found, generated if of_library and generated.is_dir() else folder / "generated"


def _fresh_module(model: Path, generated: Path, scene: "str | Scene | None") -> tuple[Path, str]:
    """A generated module that agrees with the model file, and its text; built if there is none."""
    name = scene if scene is not None else _first_scene(model, generated)
    if isinstance(name, str):
        path = scene_path(generated, model.stem, name)
        if text := fresh_text(path, model, name):
            return path, text
    built = _build(model, name, generated)
    record = unchanged(*built, model)
    if record is not None and record.unwatched:
        note(
            f"{model} asks for what nobody can watch ({'; '.join(record.unwatched)}), so it is "
            "read anew each time it is loaded."
        )
    return built


def _build(model: "Path | Model", scene: "str | Scene | None", generated: Path) -> tuple[Path, str]:
    """Have the code generator write the module; of a file without a scene it builds all."""
    with collection_paused():
        from codegen import build

        if scene is None and not isinstance(model, Path):
            scene = next(iter(model.scenes), None)
        report = build(model, scene=scene, out=generated, compile=False, unroll=None)
    first = report.scenes[0]
    return first.path, first.text


def _first_scene(model: Path, generated: Path) -> str | None:
    """The first scene that the model declares, where a record of a build knows it, else None."""
    for path in sorted(generated.glob(f"{escape(shortened(model.stem))}__*.py")):
        record = unchanged(path, None, model)
        if record is not None:
            return record.scenes[0]
    return None
