"""Records of builds: what a generated file was made from, kept beside it and not in its text.

A text follows from the generator and from all that its model asked for. A file is fresh while a
record that names its text says that all of this is as it was. Without one it is built again, and a
build that finds the same text writes the record alone.
"""

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.machinery import PathFinder
from importlib.metadata import version
from pathlib import Path
from typing import Literal, NamedTuple

from codegen.errors import InputError
from codegen.files.library_folders import LIBRARY
from codegen.files.whole_files import whole_file


class Input(NamedTuple):
    """Something that a model asked for, and the hash of what it was given, None for nothing."""

    kind: Literal["file", "folder", "variable", "working folder", "module"]
    # A path is absolute, or relative to the folder that holds `generated`; "" of a variable: all
    # names that there are.
    name: str
    value: str | None


class Record(NamedTuple):
    """What a generated file was made from."""

    text: str  # SHA-256 of the file
    generator: str
    scenes: tuple[str, ...]  # that the model declares, in order
    inputs: tuple[Input, ...]  # the model file first, if there is one
    unwatched: tuple[str, ...]  # requests of the model whose answers nobody can watch


def source_hash(*rooms: str) -> str:
    """SHA-256 of the sources in folders of the library."""
    found = hashlib.sha256()
    for file in sorted(file for room in rooms for file in LIBRARY.glob(f"{room}/**/*.py")):
        content = file.read_bytes()
        found.update(f"{file.relative_to(LIBRARY).as_posix()} {len(content)}\n".encode() + content)
    return found.hexdigest()


@cache
def generator_state() -> str:
    """The version of SymPy and the hash of the compiler's sources."""
    return f"{version('sympy')} {source_hash('codegen')}"


def relative(path: Path, base: Path) -> str:
    """A path from a folder on if it lies in it, else the path itself."""
    return (path.relative_to(base) if path.is_relative_to(base) else path).as_posix()


def value_of(kind: str, name: str | Path) -> str | None:
    """The hash of what a model is given now, None for nothing: `name` is a path or a variable."""
    try:
        if kind == "file":
            if not Path(name).is_file():  # nor is a device, which may have no end
                return None
            content = Path(name).read_bytes()
        elif kind == "folder":
            content = repr(sorted(os.listdir(name))).encode()  # noqa: PTH208 (names alone)
        elif kind == "module":  # by its place
            return str(bool(PathFinder.find_spec(Path(name).name, [str(Path(name).parent)])))
        elif kind == "variable":
            content = repr(os.environ[str(name)] if name else sorted(os.environ)).encode()
        else:
            content = os.fsencode(Path.cwd())
    except (OSError, KeyError):
        return None
    return hashlib.sha256(content).hexdigest()


def of_this_generator(path: Path, digest: str) -> bool:
    """Whether a record says that this generator made a generated file's text, of that SHA-256."""
    return any(row[:2] == (digest, generator_state()) for row in _records(path))


def unchanged(path: Path, digest: str | None, model: Path | None) -> Record | None:
    """The record of a generated file, where all that it was made from is as it was; else None.

    Its text has the SHA-256 `digest`, unless that is None, and it comes from the file `model`,
    unless that is None.
    """
    base = path.resolve().parent.parent
    for record in _records(path):
        if digest not in (None, record.text) or record.generator != generator_state():
            continue
        first = [base / row.name for row in record.inputs[:1] if row.kind == "file"]
        if model is not None and first != [model.resolve()]:
            continue
        if all(
            value_of(kind, name if kind == "variable" else base / name) == value
            for kind, name, value in record.inputs
        ):
            return record
    return None


def superseded(path: Path, digest: str, model: Path) -> bool:
    """Whether records say that a text, of this SHA-256, would be another one now."""
    return any(_records(path)) and unchanged(path, digest, model) is None


def write_record(path: Path, record: Record) -> None:
    """Keep the record of a generated file, where a folder for it can be written."""
    if record in _records(path):
        return
    for place in _places(path):
        with suppress(OSError, InputError):
            place.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(place) as file:
                file.write_text(json.dumps(record), encoding="utf-8")
            return


def _records(path: Path) -> Iterator[Record]:
    """All records of a generated file that can be read."""
    for place in _places(path):
        with suppress(OSError, ValueError, TypeError):
            text, generator, scenes, inputs, unwatched = json.loads(place.read_bytes())
            rows = tuple(Input(*row) for row in inputs)
            yield Record(text, generator, tuple(scenes), rows, tuple(unwatched))


def _places(path: Path) -> Iterator[Path]:
    """Where a record may be: beside the machine code of the file."""
    name = f"{path.stem}.build.json"
    yield path.parent / "__pycache__" / name
    from codegen.machine_code.code_folders import code_folders  # which loads numba

    folders = code_folders(path.parent)
    yield from (folder / name for folder in folders if folder != path.parent / "__pycache__")
