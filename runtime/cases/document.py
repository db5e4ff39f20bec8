"""Documents of data, YAML or JSON, read into entries that know their lines; nothing is executed.

YAML is read by its core schema (version 1.2) from PyYAML's tree of nodes, so that no tag constructs
anything, `1e-8` is a number and `on` a text. JSON is read by Python's own reader. Keys are words,
and a key that stands twice is refused.
"""

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from os import fspath
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.readers.values import finite_float, is_flag, shown

ENDINGS = (".yaml", ".yml", ".json")
_MOST_BYTES = 1 << 20  # safety: of a document
_MOST_VALUES = 100_000  # safety: of a document, aliases written out
_DEEPEST = 20  # safety: mappings and lists in one another

_TAG = "tag:yaml.org,2002:"
_RESOLVED = (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9]+", list("-+0123456789")),
    ("float", r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?", list("-+0123456789.")),
)
"""Tags of plain scalars in YAML's core schema, but for octal, hexadecimal, infinite and nan."""


class Entry(NamedTuple):
    """A value: a mapping of entries, a list of entries, or text, number, True, False or None."""

    value: Any
    line: int | None = None

    def plain(self) -> Any:
        """The value without lines."""
        if isinstance(self.value, dict):
            return {name: entry.plain() for name, entry in self.value.items()}
        if isinstance(self.value, list):
            return [entry.plain() for entry in self.value]
        return self.value


class _ContentError(Exception):
    """Something that a document must not have, and its line."""

    def __init__(self, text: str, line: int | None = None) -> None:
        super().__init__(text)
        self.line = line


def read_document(path: Path) -> Entry:
    """The entries of a file; InputError says its line where something is wrong."""
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"{path}: a case is a file ending in {', '.join(ENDINGS)}.")
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
        if len(content) > _MOST_BYTES:
            raise InputError(f"{path} has more than {_MOST_BYTES >> 20} MiB, and is no case.")
        text = content.decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8 ({error.reason}).") from error
    try:
        return _of_json(text) if path.suffix.lower() == ".json" else _of_yaml(path, text)
    except _ContentError as error:
        raise InputError(f"{place(path, error.line)}: {error}") from error
    except RecursionError as error:
        raise InputError(f"{path} has lists or mappings that are too deep.") from error


def place(path: object, line: int | None) -> str:
    """A file and a line of it, as messages begin."""
    return f"{path}, line {line}" if line is not None else f"{path}"


def entry_of(value: Any, depth: int = 0) -> Entry:
    """The entry of a value of Python: numbers, also NumPy's, texts, mappings and lists of them.

    Paths and all else stay as they are, so that the reader of a field can refuse them.
    """
    if isinstance(value, Entry):
        return value
    if depth < _DEEPEST and isinstance(value, Mapping):
        return Entry({k: entry_of(v, depth + 1) for k, v in value.items()})
    if depth < _DEEPEST and (isinstance(value, list | tuple) or getattr(value, "ndim", 0) == 1):
        return Entry([entry_of(v, depth + 1) for v in value])
    if isinstance(value, np.generic):
        value = value.item()
    if hasattr(value, "__fspath__"):
        return Entry(fspath(value))
    if isinstance(value, str | int | None) or is_flag(value):
        return Entry(bool(value) if is_flag(value) else value)
    number = finite_float(value)
    return Entry(value if number is None else number)


def _of_json(text: str) -> Entry:
    def mapping(pairs: Iterable[tuple[str, Any]]) -> Entry:
        found = dict[str, Entry]()
        for name, value in pairs:
            if name in found:
                raise _ContentError(f"{shown(name)} stands twice in one mapping; keep one.")
            found[name] = written(value)
        return Entry(found)

    def written(value: Any) -> Entry:
        if isinstance(value, Entry):
            return value
        return Entry([written(v) for v in value] if isinstance(value, list) else value)

    def constant(name: str) -> None:
        raise _ContentError(f"{name} is no number; give a finite one.")

    try:
        found = written(json.loads(text, object_pairs_hook=mapping, parse_constant=constant))
    except json.JSONDecodeError as error:
        raise _ContentError(f"{error.msg}; the file is no JSON.", error.lineno) from error
    except ValueError as error:  # of a number of thousands of digits
        raise _ContentError(f"a number cannot be read ({error}).") from error
    _bound(found)
    return found


def _bound(entry: Entry, depth: int = 0) -> None:
    """Refuse what is too deep, as the entries of YAML are while they are read."""
    if depth > _DEEPEST:
        raise _ContentError(f"it has more than {_DEEPEST} mappings and lists in one another.")
    inner = entry.value
    for part in (
        inner.values() if isinstance(inner, dict) else inner if isinstance(inner, list) else ()
    ):
        _bound(part, depth + 1)


def yaml_module(path: object) -> Any:
    """PyYAML; InputError where it is missing."""
    try:
        import yaml
    except ImportError as error:
        raise InputError(
            f"{path}: YAML needs the library PyYAML, which cannot be imported ({error}). Run pip "
            "install 'linkwright[files]', in the checkout pip install '.[files]', or use .json."
        ) from error
    return yaml


def with_core_schema(kind: Any) -> Any:
    """A loader or dumper of PyYAML that takes plain scalars by YAML's core schema."""
    made: Any = type(kind.__name__, (kind,), {"yaml_implicit_resolvers": {}})
    for name, form, first in _RESOLVED:
        made.add_implicit_resolver(_TAG + name, re.compile(rf"(?:{form})\Z"), first)
    return made


@cache
def _loader() -> Any:
    return with_core_schema(yaml_module("YAML").SafeLoader)


def _of_yaml(path: Path, text: str) -> Entry:
    yaml = yaml_module(path)
    try:
        tree = yaml.compose(text, _loader())
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        why = " ".join(filter(None, (error.context, error.problem)))
        raise _ContentError(f"{why}; the file is no YAML.", mark and mark.line + 1) from error
    except yaml.YAMLError as error:
        raise _ContentError(f"{' '.join(str(error).split())}; the file is no YAML.") from error
    if tree is None:
        raise _ContentError("the file is empty.")
    return _Nodes(yaml).entry(tree, 0)


class _Nodes:
    """Nodes of PyYAML into entries, as many as a document may have."""

    def __init__(self, yaml: Any) -> None:
        self.yaml, self.count = yaml, 0

    def entry(self, node: Any, depth: int) -> Entry:
        """The entry of a node; what an alias names is written out again."""
        line, self.count = node.start_mark.line + 1, self.count + 1
        if self.count > _MOST_VALUES:
            raise _ContentError(
                f"it has more than {_MOST_VALUES} values, aliases written out.", line
            )
        if depth > _DEEPEST:
            raise _ContentError(
                f"it has more than {_DEEPEST} mappings and lists in one another.", line
            )
        kind = node.tag.removeprefix(_TAG)
        if isinstance(node, self.yaml.MappingNode) and kind == "map":
            return Entry(self._mapping(node, depth), line)
        if isinstance(node, self.yaml.SequenceNode) and kind == "seq":
            return Entry([self.entry(part, depth + 1) for part in node.value], line)
        if isinstance(node, self.yaml.ScalarNode) and (read := _SCALARS.get(kind)) is not None:
            try:
                return Entry(read(node.value), line)
            except (ValueError, KeyError) as error:
                raise _ContentError(f"{shown(node.value)} is no {kind}.", line) from error
        raise _ContentError(
            f"the tag {shown(node.tag)} is none of a case: it has data alone.", line
        )

    def _mapping(self, node: Any, depth: int) -> dict[str, Entry]:
        found = dict[str, Entry]()
        for key, value in node.value:
            name = self.entry(key, depth + 1)
            if not isinstance(name.value, str):
                raise _ContentError(
                    f"the key {shown(name.plain())} is no word; quote it.", name.line
                )
            if name.value in found:
                raise _ContentError(f"{shown(name.value)} stands twice in one mapping.", name.line)
            found[name.value] = self.entry(value, depth + 1)._replace(line=name.line)
        return found


_SCALARS: dict[str, Callable[[str], Any]] = {
    "str": str,
    "null": lambda _: None,
    "bool": lambda text: {"true": True, "false": False}[text.lower()],
    "int": int,
    "float": float,
}


@contextmanager
def errors_at(where: str) -> Iterator[None]:
    """Let errors of ours begin with a place."""
    try:
        yield
    except InputError as error:
        error.locate(where)
        raise
