"""Where the library's own files lie, in a checkout or an installed wheel, and where packages do.

A checkout has `models` and `generated` beside the packages. A wheel has neither, since no other
name belongs to it at the top level of an environment: its explicit methods lie in the runtime.
"""

import sysconfig
from difflib import get_close_matches
from functools import cache
from pathlib import Path

from codegen.errors import ModelFileError
from codegen.readers.values import one_line, shown

LIBRARY = Path(__file__).resolve().parents[2]
"""The folder that holds the library's packages."""

if not (LIBRARY / "codegen").is_dir():
    raise ImportError(
        f"Linkwright is imported from the archive {LIBRARY}, and needs folders: it compiles its "
        "files, and keeps machine code beside them. Install it, with pip install, or unpack it."
    )
_IN_WHEELS = "runtime/generated"
_LONGEST_PATH = 1000  # layout: characters of a path in a message


def is_checkout(library: Path = LIBRARY) -> bool:
    """Whether `models` and `generated` beside the packages are the library's own."""
    return not (library / _IN_WHEELS).is_dir()


@cache
def installed_folders() -> frozenset[Path]:
    """Folders of Python's own modules and of installed packages, without symbolic links."""
    paths = sysconfig.get_paths()
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    return frozenset(Path(paths[name]).resolve() for name in names)


def is_installed(path: Path) -> bool:
    """Whether a file, without symbolic links, is Python's or of a package, wherever that lies."""
    packages = {"site-packages", "dist-packages"}.intersection(path.parts)
    return bool(packages) or any(map(path.is_relative_to, installed_folders()))


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


def find_model_file(model: str | Path, folder: Path | None = None, library: Path = LIBRARY) -> Path:
    """The file of a model: a path, or a name for ``models/NAME.py`` of a folder or the library.

    A name may contain folders: ``hard/pendulum`` is ``models/hard/pendulum.py``, unless there is a
    file of that path itself. The folder is the working folder unless given.

    Raises ModelFileError if there is none; it has the nearest names.
    """
    given, here = Path(model), folder or Path.cwd()
    is_path = given.suffix == ".py" or given.is_absolute()
    tried = [here / given] if is_path or len(given.parts) > 1 else []
    if not is_path:
        places = (here / "models", models_folder(library))
        tried += [place / f"{given}.py" for place in places if place]
    try:
        for path in tried:
            if path.is_file():
                return path.resolve()
        names = sorted({name for path in tried for name in model_names(path.parent)})
        beside = (here / f"{given}.py").is_file()
    except OSError as error:
        raise ModelFileError(f"no file can be {shown(str(model))}: {error.strerror}.") from error
    near = get_close_matches(given.stem, names, n=3, cutoff=0.5) or names
    hint = f" Models there: {', '.join(near)}." if near else ""
    if beside:
        hint = f" A path ends in .py: did you mean {given}.py?"
    elif not is_path and not is_checkout(library):
        hint += " The machines of the library come with the checkout, not with a wheel."
    places_tried = " and ".join(one_line(path, _LONGEST_PATH) for path in dict.fromkeys(tried))
    raise ModelFileError(f"There is no model {shown(str(model))}: looked for {places_tried}.{hint}")


def methods_folder() -> Path:
    """The folder of the explicit methods, which are written from their tableaus."""
    return LIBRARY / ("generated" if is_checkout() else _IN_WHEELS) / "methods"
