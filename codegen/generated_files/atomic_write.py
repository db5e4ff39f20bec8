"""Files appear whole or not at all, and are touched only when their bytes change."""

import os
import tempfile
from pathlib import Path

from codegen.artefact import alone
from codegen.errors import GeneratedFileError


def write_if_changed(path: Path, text: str) -> bool:
    """Put `text` at `path` in one step; False if it was there already.

    Two builds of the same model write the same bytes, so the later rename changes nothing.

    Raises
    ------
    GeneratedFileError
        If the folder cannot be made or written.
    """
    try:
        if is_current(path, text):
            return False
        path.parent.mkdir(parents=True, exist_ok=True)
        with alone(path):
            _replace(path, text)
    except OSError as error:
        raise GeneratedFileError(
            f"cannot write {path}: {error.strerror or error}; choose another folder with --out, "
            "or make this one writable."
        ) from error
    return True


def is_current(path: Path, text: str) -> bool:
    """Whether `path` holds `text`."""
    return path.is_file() and path.read_bytes() == text.encode()


def _replace(path: Path, text: str) -> None:
    descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-")
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(text.encode())
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
