"""Documents of data, YAML or JSON, read with the lines of their values, and written.

YAML is read by its core schema (version 1.2) from PyYAML's tree of nodes, so that no tag constructs
anything, `1e-8` is a number and `on` a text. JSON is read by Python's own reader. Keys are words,
and a key that stands twice is refused.
"""

import json
import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from os import fspath
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.readers.values import finite_float, shown

ENDINGS = (".yaml", ".yml", ".json")
_MOST_BYTES = 1 << 20  # safety: of a document
_MOST_VALUES = 100_000  # safety: of a document, aliases written out
_DEEPEST = 20  # safety: mappings and lists in one another
_WIDTH = 100  # layout: characters of a line

_TAG = "tag:yaml.org,2002:"
_RESOLVED = (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9]+", list("-+0123456789")),
    ("float", r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?", list("-+0123456789.")),
)
"""Tags of plain scalars in YAML's core schema, but for octal, hexadecimal, infinite and nan."""

_SCALARS: dict[str, Callable[[str], Any]] = {
    "str": str,
    "null": lambda _: None,
    "bool": lambda text: {"true": True, "false": False}[text.lower()],
    "int": int,
    "float": float,
}
Place = tuple[str | int, ...]
"""Keys and indices that lead to a value."""


class Document(NamedTuple):
    """Nested mappings, lists, texts, numbers, True, False and None, with the lines of a file."""

    data: Any
    file: Path | None = None
    lines: Mapping[Place, int] = {}

    def line(self, at: Place) -> int | None:
        """The line of a value, or of what it would lie in; None where lines are not known."""
        return next(
            (self.lines[at[:n]] for n in range(len(at), -1, -1) if at[:n] in self.lines), None
        )

    def place(self, at: Place) -> str:
        """The file and the line of a value, as messages begin."""
        return _place(self.file or "Case", self.line(at))

    def problem(self, at: Place, why: str, line_of: Place | None = None) -> str:
        """A sentence about a value, behind its file, its line and its path in the document."""
        where = self.place(at if line_of is None else line_of)
        path = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in at)
        return f"{where}{', ' * bool(path)}{path.removeprefix('.')}: {why}"


def _place(file: object, line: int | None) -> str:
    return f"{file}" if line is None else f"{file}, line {line}"


def plain(value: Any) -> Any:
    """Data of Python as documents have them: NumPy's arrays and numbers too, and paths as texts.

    All else stays as it is, so that the check of its field can refuse it.
    """
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(part) for part in value]
    if hasattr(value, "__fspath__"):
        return fspath(value)
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, str | int | float | None):
        return value
    number = finite_float(value)
    return value if number is None else number


def read_document(path: Path) -> Document:
    """The data of a file; InputError says its line where something is wrong."""
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"{path}: a case is a file ending in {', '.join(ENDINGS)}.")
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
        if len(content) > _MOST_BYTES:
            raise InputError(f"{path} has more than {_MOST_BYTES >> 20} MiB, and is no case.")
        text = content.decode("utf-8-sig")
        return _of_json(path, text) if path.suffix.lower() == ".json" else _of_yaml(path, text)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8 ({error.reason}).") from error
    except RecursionError as error:
        raise InputError(f"{path} has lists or mappings that are too deep.") from error


def _of_json(path: Path, text: str) -> Document:
    def mapping(pairs: Iterable[tuple[str, Any]]) -> dict[str, Any]:
        found = dict[str, Any]()
        for name, value in pairs:
            if name in found:
                raise InputError(f"{path}: {shown(name)} stands twice in one mapping; keep one.")
            found[name] = value
        return found

    def constant(name: str) -> None:
        raise InputError(f"{path}: {name} is no number; give a finite one.")

    try:
        data = json.loads(text, object_pairs_hook=mapping, parse_constant=constant)
    except json.JSONDecodeError as error:
        where = _place(path, error.lineno)
        raise InputError(f"{where}: {error.msg}; the file is no JSON.") from error
    except ValueError as error:  # of a number of thousands of digits
        raise InputError(f"{path}: a number cannot be read ({error}).") from error
    return Document(data, path)


def _of_yaml(path: Path, text: str) -> Document:
    yaml = _yaml_module(path)
    try:
        tree = yaml.compose(text, _loader())
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        why = " ".join(str(error if mark is None else error.problem).split())
        where = _place(path, mark and mark.line + 1)
        raise InputError(f"{where}: {why}; the file is no YAML.") from error
    if tree is None:
        raise InputError(f"{path}: the file is empty.")
    lines = dict[Place, int]()
    return Document(_Nodes(path, lines).value(tree, ()), path, lines)


class _Nodes:
    """Nodes of PyYAML into data, as many as a document may have; their lines are noted."""

    def __init__(self, path: Path, lines: dict[Place, int]) -> None:
        self.path, self.lines, self.count = path, lines, 0

    def value(self, node: Any, at: Place) -> Any:
        """The value of a node; what an alias names is written out again."""
        line, self.count = node.start_mark.line + 1, self.count + 1
        self.lines.setdefault(at, line)
        if self.count > _MOST_VALUES:
            raise self.error(line, f"it has more than {_MOST_VALUES} values, aliases written out.")
        if len(at) > _DEEPEST:
            raise self.error(
                line, f"it has more than {_DEEPEST} mappings and lists in one another."
            )
        kind = node.tag.removeprefix(_TAG)
        if node.id == "mapping" and kind == "map":
            return self.mapping(node, at)
        if node.id == "sequence" and kind == "seq":
            return [self.value(part, (*at, k)) for k, part in enumerate(node.value)]
        if node.id == "scalar" and (read := _SCALARS.get(kind)) is not None:
            try:
                return read(node.value)
            except (ValueError, KeyError) as error:
                raise self.error(line, f"{shown(node.value)} is no {kind}.") from error
        raise self.error(line, f"the tag {shown(node.tag)} is none of a case: it has data alone.")

    def mapping(self, node: Any, at: Place) -> dict[str, Any]:
        """The mapping of a node; its values have the lines of their keys."""
        found = dict[str, Any]()
        for key, value in node.value:
            line = key.start_mark.line + 1
            name = self.value(key, (*at, ""))
            if not isinstance(name, str):
                raise self.error(line, f"the key {shown(name)} is no word; quote it.")
            if name in found:
                raise self.error(line, f"{shown(name)} stands twice in one mapping.")
            self.lines[*at, name] = line
            found[name] = self.value(value, (*at, name))
        return found

    def error(self, line: int, why: str) -> InputError:
        """The error about something that a document must not have."""
        return InputError(f"{_place(self.path, line)}: {why}")


def text_of(data: dict[str, Any], path: Path) -> str:
    """The document by the ending of `path`, its keys in their order; it is read with the same bits.

    Texts that YAML's core schema would read as something else are quoted.
    """
    if path.suffix.lower() == ".json":
        return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    written: str = _yaml_module(path).dump(
        data, Dumper=_dumper(), sort_keys=False, allow_unicode=True, width=_WIDTH
    )
    return written


def _yaml_module(path: object) -> Any:
    """PyYAML; InputError where it is missing."""
    try:
        import yaml
    except ImportError as error:
        raise InputError(
            f"{path}: YAML needs the library PyYAML, which cannot be imported ({error}). Run pip "
            "install 'linkwright[files]', in the checkout pip install '.[files]', or use .json."
        ) from error
    return yaml


def _with_core_schema(kind: Any) -> Any:
    """A loader or dumper of PyYAML that takes plain scalars by YAML's core schema."""
    made: Any = type(kind.__name__, (kind,), {"yaml_implicit_resolvers": {}})
    for name, form, first in _RESOLVED:
        made.add_implicit_resolver(_TAG + name, re.compile(rf"(?:{form})\Z"), first)
    return made


@cache
def _loader() -> Any:
    return _with_core_schema(_yaml_module("YAML").SafeLoader)


@cache
def _dumper() -> Any:
    dumper = _with_core_schema(_yaml_module("YAML").SafeDumper)
    dumper.ignore_aliases = lambda *_: True
    return dumper
