"""Where the library's own files lie: in a checkout, or in an installed wheel.

A checkout has `models` and `generated` beside the packages. A wheel has neither, since no other
name belongs to it at the top level of an environment: its explicit methods lie in the runtime.
"""

from pathlib import Path

LIBRARY = Path(__file__).resolve().parent.parent
"""The folder that holds the library's packages."""

_IN_WHEELS = "runtime/generated"


def is_checkout(library: Path = LIBRARY) -> bool:
    """Whether `models` and `generated` beside the packages are the library's own."""
    return not (library / _IN_WHEELS).is_dir()


def models_folder(library: Path = LIBRARY) -> Path | None:
    """The folder of the library's models; None where it is installed without them."""
    folder = library / "models"
    return folder if is_checkout(library) and folder.is_dir() else None


def methods_folder() -> Path:
    """The folder of the explicit methods, which are written from their tableaus."""
    return LIBRARY / ("generated" if is_checkout() else _IN_WHEELS) / "methods"
