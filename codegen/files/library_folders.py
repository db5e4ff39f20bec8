"""Where the library's own files lie, in a checkout or an installed wheel, and where packages do.

A checkout has `models` and `generated` beside the packages. A wheel has neither, since no other
name belongs to it at the top level of an environment: its explicit methods lie in the runtime.
"""

import sysconfig
from functools import cache
from pathlib import Path

LIBRARY = Path(__file__).resolve().parents[2]
"""The folder that holds the library's packages."""

_IN_WHEELS = "runtime/generated"


def is_checkout(library: Path = LIBRARY) -> bool:
    """Whether `models` and `generated` beside the packages are the library's own."""
    return not (library / _IN_WHEELS).is_dir()


@cache
def installed_folders() -> frozenset[Path]:
    """Folders of Python's own modules and of installed packages, without symbolic links."""
    paths = sysconfig.get_paths()
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    return frozenset(Path(paths[name]).resolve() for name in names)


def models_folder(library: Path = LIBRARY) -> Path | None:
    """The folder of the library's models; None where it is installed without them."""
    folder = library / "models"
    return folder if is_checkout(library) and folder.is_dir() else None


def model_names(folder: Path) -> list[str]:
    """Names of the model files of a folder: in one called `models` all, else what says Model(."""
    if not folder.is_dir():
        return []
    files = (path for path in folder.glob("[!_]*.py") if path.is_file())
    return sorted(x.stem for x in files if folder.name == "models" or _names_a_model(x))


def _names_a_model(path: Path) -> bool:
    try:
        return b"Model(" in path.read_bytes()
    except OSError:
        return False


def file_beside(model: str, folder: Path) -> str:
    """Hint, after a blank, at the file of a name that lacks its suffix."""
    found = folder / f"{model}.py"
    return f" A path ends in .py: did you mean {model}.py?" if found.is_file() else ""


def methods_folder() -> Path:
    """The folder of the explicit methods, which are written from their tableaus."""
    return LIBRARY / ("generated" if is_checkout() else _IN_WHEELS) / "methods"
