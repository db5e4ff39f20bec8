"""Model file → the `Model` that it declares, and the local source files."""

import contextlib
import hashlib
import importlib.util
import os
import sys
import threading
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType

from codegen.errors import InputError, ModelFileError
from codegen.files.build_records import Input
from codegen.files.generated_modules import is_signed
from codegen.files.library_folders import find_model_file
from codegen.model import Model
from codegen.readers.arguments import NOT_TEXT
from codegen.readers.calls import sympy_remedy
from codegen.readers.values import shown
from codegen.reading.watched_inputs import Watch, is_local, unseen_requests, watched

_IN_USE = {
    *("codegen", "linkwright", "runtime", "filelock", "llvmlite", "matplotlib", "mpmath"),
    *("netCDF4", "numba", "numpy", "pandas", "pint", "pyarrow", "pydantic", "rich", "scipy"),
    *("sympy", "typer", "xarray"),
}
_KEPT = {"__main__", "__mp_main__", *sys.stdlib_module_names, *_IN_USE}
"""Modules that a file beside a model file does not replace."""
_one_at_a_time = threading.RLock()  # what a model asks for is noted for the whole process


@dataclass(frozen=True)
class ModelFile:
    """A model, its file, and the SHA-256 of every local file that declares it.

    A model that was declared in a running program has no file; it goes by its own name.
    """

    model: Model
    path: Path | None
    sources: tuple[tuple[Path, str], ...]
    asked: tuple[Input, ...] = ()  # what else it asked for while it ran
    unwatched: tuple[str, ...] = ()  # requests whose answers nobody can watch

    @property
    def stem(self) -> str:
        """Beginning of the names of the generated files."""
        return self.path.stem if self.path else self.model.name


def read_model(model: str | Path | Model) -> ModelFile:
    """Read the model of a path or bare name; a `Model` is returned as it is."""
    if isinstance(model, Model):
        return ModelFile(model, None, ())
    return execute_model_file(find_model_file(model))


def execute_model_file(path: Path) -> ModelFile:
    """Execute a model file and return the model that it declares.

    ModelFileError where it fails, or declares no model, or several without calling one `model`.
    """
    _require_plain_name(path)
    if is_signed(_read(path).decode(errors="replace")):
        # Executed here, its functions would enter numba's cache under a name that nothing can load.
        raise ModelFileError(
            f"{path} is a module that was generated from a model, and declares none; give the "
            "model and the scene that it names in its first lines."
        )
    namespace, files, watch = _execute(path)
    models = {id(v): v for v in namespace.values() if isinstance(v, Model)}
    declared = models.get(id(namespace.get("model")))
    if declared is None:
        if len(models) != 1:
            names = ", ".join(repr(m.name) for m in models.values())
            raise ModelFileError(
                f"{path} declares {f'several models ({names})' if models else 'no model'}; "
                "assign the one to build to the name 'model': model = Model(...)."
            )
        (declared,) = models.values()
    files += [file for file in declared.files if file not in files]
    asked = tuple(row for row in watch.inputs() if Path(row.name) not in files)
    return ModelFile(
        declared, path, tuple((p, file_hash(p)) for p in files), asked, tuple(watch.unwatched)
    )


def file_hash(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    return hashlib.sha256(_read(path)).hexdigest()


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise ModelFileError(f"{path} cannot be read: {error.strerror}.") from error


def _require_plain_name(path: Path) -> None:
    """Refuse a file whose name cannot become part of the names of generated modules."""
    odd = [c for c in path.stem if not c.isprintable() or c in "{}"]
    if any("\ud800" <= c <= "\udfff" for c in str(path)):
        raise ModelFileError(f"no model file can be {shown(str(path))} ({NOT_TEXT}).")
    if odd:
        raise ModelFileError(
            f"{shown(str(path))}: the generated files are named after the model file, and "
            f"{', '.join(dict.fromkeys(map(repr, odd)))} cannot be part of their names. Rename it."
        )


def _execute(path: Path) -> tuple[dict[str, object], list[Path], Watch]:
    """The names that a model file defines, its local source files, and what it asked for."""
    spec = importlib.util.spec_from_file_location(f"_linkwright_model_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        with _one_at_a_time, _fresh_imports(path.parent), contextlib.redirect_stdout(sys.stderr):
            with watched() as watch:
                spec.loader.exec_module(module)
            modules = [module for _, module in sorted(_modules_of_user().items())]
            names = [str(path), *(str(module.__file__) for module in modules)]
            files = [*dict.fromkeys(Path(name).resolve() for name in names)]
            watch.unwatched |= dict.fromkeys(unseen_requests(files))
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
        line = f", line {frames[-1].lineno}" if frames else ""
        if isinstance(error, InputError):
            if frames:
                error.locate(f"{path}{line}")
            raise
        if isinstance(error, SyntaxError) and error.filename == str(path):
            line = f", line {error.lineno}" if error.lineno else ""
        remedy = sympy_remedy(error)
        said = f"{type(error).__name__}: {error}"
        why = f"{remedy}. ({said})" if remedy else f"the model file fails with {said}"
        raise ModelFileError(f"{path}{line}: {why}") from error
    return vars(module), files, watch


class _Siblings:
    """Finder of the modules beside a model file: before installed ones, not before those in use."""

    def __init__(self, folder: Path) -> None:
        self.folder = str(folder)

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The specification of a neighbour; None leaves the search to others."""
        if path is not None or name in _KEPT:
            return None
        return PathFinder.find_spec(name, [self.folder], target)


@contextlib.contextmanager
def _fresh_imports(folder: Path) -> Iterator[None]:
    """Import local files as they are now, those of `folder` first, and forget them afterwards."""
    held, writes = _modules_of_user(), sys.dont_write_bytecode
    for name in held:
        del sys.modules[name]
    search, here, siblings = sys.path[:], Path.cwd(), _Siblings(folder)
    sys.meta_path.insert(0, siblings)
    sys.path.append(str(folder))
    sys.dont_write_bytecode = True  # its date is in seconds
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.path[:] = search
        sys.meta_path[:] = [finder for finder in sys.meta_path if finder is not siblings]
        os.chdir(here)
        sys.dont_write_bytecode = writes
        for name in _modules_of_user():
            del sys.modules[name]
        sys.modules.update(held)


def _modules_of_user() -> dict[str, ModuleType]:
    """Modules in use from local Python files, which can be imported once more, by their names."""
    files = {name: str(getattr(x, "__file__", "")) for name, x in [*sys.modules.items()]}
    return {
        name: sys.modules[name] for name, file in files.items()
        if name not in _KEPT and file.endswith(".py") and is_local(file)
    }  # fmt: skip
