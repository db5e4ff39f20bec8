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
from importlib.metadata import version
from pathlib import Path
from typing import Literal, NamedTuple

from codegen.errors import InputError
from codegen.files.generated_modules import check_signature, read_generated, text_hash
from codegen.files.library_folders import LIBRARY
from codegen.files.whole_files import whole_file


class Input(NamedTuple):
    """Something that a model asked for, and the hash of what it was given, None for nothing."""

    kind: Literal["file", "folder", "variable", "working folder"]
    name: str  # an absolute path; "" of a variable: all names that there are
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


def value_of(kind: str, name: str) -> str | None:
    """The hash of what a model is given now, None for nothing: `name` is a path or a variable."""
    try:
        if kind == "file":
            if not Path(name).is_file():  # nor is a device, which may have no end
                return None
            content = Path(name).read_bytes()
        elif kind == "folder":
            content = repr(sorted(os.listdir(name))).encode()  # noqa: PTH208 (names alone)
        elif kind == "variable":
            content = repr(os.environ[name] if name else sorted(os.environ)).encode()
        else:
            content = os.fsencode(Path.cwd())
    except (OSError, KeyError):
        return None
    return hashlib.sha256(content).hexdigest()


def of_this_generator(path: Path, text: str) -> bool:
    """Whether a record says that this generator made a generated file's text."""
    return any(row[:2] == (text_hash(text), generator_state()) for row in records(path))


def unchanged(path: Path, text: str | None, model: Path) -> Record | None:
    """The record of a file that was generated from `model`, if all is as it was; else None.

    Any text will do where that is None.
    """
    digest = text and text_hash(text)
    for record in records(path):
        if (
            digest in (None, record.text)
            and record.generator == generator_state()
            and [row.name for row in record.inputs[:1]] == [str(model)]
            and all(value_of(kind, name) == value for kind, name, value in record.inputs)
        ):
            return record
    return None


def fresh_text(path: Path, model: Path, scene: str) -> str | None:
    """The text of a scene's file; None where that, or its model, must be read anew.

    Raises GeneratedFileError if it was edited by hand.
    """
    if not path.is_file():
        return None
    text = read_generated(path)
    check_signature(path, text, f"linkwright build {model} --scene {scene} --out {path.parent}")
    record = unchanged(path, text, model)
    return text if record and not record.unwatched else None


def write_record(path: Path, record: Record) -> None:
    """Keep the record of a generated file, where a folder for it can be written."""
    if record in records(path):
        return
    for place in _places(path):
        with suppress(OSError, InputError):
            place.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(place) as file:
                file.write_text(json.dumps(record), encoding="utf-8")
            return


def records(path: Path) -> Iterator[Record]:
    """All records of a generated file that can be read."""
    for place in _places(path):
        with suppress(OSError, ValueError, TypeError):
            text, generator, scenes, inputs, unwatched = json.loads(place.read_bytes())
            rows = tuple(Input(*row) for row in inputs)
            yield Record(text, generator, tuple(scenes), rows, tuple(unwatched))


def _places(path: Path) -> Iterator[Path]:
    """Where a record may be: beside the machine code of the file."""
    from codegen.machine_code.code_folders import code_folders  # which loads numba

    for folder in dict.fromkeys([path.parent / "__pycache__", *code_folders(path.parent)]):
        yield folder / f"{path.stem}.build.json"
