"""Kinds of values in a document: what fits a field, and the same as a JSON schema."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from codegen.readers.quantities import (
    FORM,
    QUANTITY,
    QuantityError,
    number_in,
    pint_form,
    read_condition,
)
from codegen.readers.values import shown
from runtime.cases.document import Entry
from runtime.mechanism.table_rows import unknown

_LONGEST = 4096  # safety: characters of a text
_NUMBER_WITH_UNIT = QUANTITY.pattern.replace(r"(\S.*)?", r"(\S(.|\n)*)?")

Note = Callable[[str, Entry, str], None]
"""Takes a problem: path of the value in the document, the value, and a sentence."""


class Kind(Protocol):
    """A kind of value."""

    def check(self, entry: Entry, where: str, note: Note) -> None:
        """Note all that does not fit."""

    def schema(self) -> dict[str, Any]:
        """The kind as a JSON schema."""


@dataclass(frozen=True)
class Scalar:
    """A text, a number or a flag."""

    demand: str
    form: Mapping[str, Any]
    problem: Callable[[Any], str | None]  # why a value does not fit; empty: it is another kind

    def check(self, entry: Entry, where: str, note: Note) -> None:
        """Note all that does not fit."""
        why = self.problem(entry.value)
        if why is not None:
            note(where, entry, why or f"{shown(entry.plain())}: it must be {self.demand}.")

    def schema(self) -> dict[str, Any]:
        """The kind as a JSON schema."""
        return dict(self.form)


@dataclass(frozen=True)
class ListOf:
    """A list of values of one kind."""

    kind: Kind
    least: int = 0

    def check(self, entry: Entry, where: str, note: Note) -> None:
        """Note all that does not fit."""
        if not isinstance(entry.value, list) or len(entry.value) < self.least:
            note(where, entry, f"{shown(entry.plain())}: it must be a list.")
            return
        for k, part in enumerate(entry.value):
            self.kind.check(part, f"{where}[{k}]", note)

    def schema(self) -> dict[str, Any]:
        """The kind as a JSON schema."""
        least = {"minItems": self.least} if self.least else {}
        return {"type": "array", "items": self.kind.schema(), **least}


@dataclass(frozen=True)
class MapOf:
    """A mapping from names of the model to values of one kind."""

    kind: Kind

    def check(self, entry: Entry, where: str, note: Note) -> None:
        """Note all that does not fit."""
        if not isinstance(entry.value, dict):
            note(where, entry, f"{shown(entry.plain())}: it must be a mapping, NAME: VALUE.")
            return
        for name, part in entry.value.items():
            if TEXT.problem(name) is not None:
                note(where, part, f"the name {shown(name)} is no text that prints.")
            self.kind.check(part, f"{where}.{name}", note)

    def schema(self) -> dict[str, Any]:
        """The kind as a JSON schema."""
        return {"type": "object", "additionalProperties": self.kind.schema()}


@dataclass(frozen=True)
class Field:
    """A key of a record."""

    kind: Kind
    about: str
    required: bool = False


@dataclass(frozen=True)
class Record:
    """A mapping with known keys."""

    fields: Mapping[str, Field]
    title: str = ""
    about: str = field(default="", compare=False)

    def check(self, entry: Entry, where: str, note: Note) -> None:
        """Note all that does not fit."""
        if not isinstance(entry.value, dict):
            note(where, entry, f"{shown(entry.plain())}: it must be a mapping, KEY: VALUE.")
            return
        for name, part in entry.value.items():
            inner = f"{where}.{name}" if where else f"{name}"
            if name in self.fields:
                self.fields[name].kind.check(part, inner, note)
            else:
                note(where, part, unknown("key", name, self.fields))
        missing = [k for k, of in self.fields.items() if of.required and k not in entry.value]
        for name in missing:
            note(where, entry, f"{name} is missing: {self.fields[name].about}")

    def schema(self) -> dict[str, Any]:
        """The kind as a JSON schema."""
        required = [name for name, of in self.fields.items() if of.required]
        return {
            **({"title": self.title} if self.title else {}),
            **({"description": self.about} if self.about else {}),
            "type": "object",
            "properties": {
                name: {**of.kind.schema(), "description": of.about}
                for name, of in self.fields.items()
            },
            **({"required": required} if required else {}),
            "additionalProperties": False,
        }


@dataclass(frozen=True)
class Either:
    """A value of one of two kinds; a mapping or list is checked as the second."""

    first: Kind
    second: Kind

    def check(self, entry: Entry, where: str, note: Note) -> None:
        """Note all that does not fit."""
        nested = isinstance(entry.value, dict | list)
        (self.second if nested else self.first).check(entry, where, note)

    def schema(self) -> dict[str, Any]:
        """The kind as a JSON schema."""
        return {"anyOf": [self.first.schema(), self.second.schema()]}


def _is_number(value: object) -> bool:
    return type(value) in (int, float) and math.isfinite(float(value))  # type: ignore[arg-type]


def _text_problem(value: object) -> str | None:
    if not isinstance(value, str):
        return ""
    if not value or len(value) > _LONGEST or not value.isprintable():
        return f"{shown(value)}: it must be a text of 1 to {_LONGEST} characters that print."
    return None


def _number_problem(value: object) -> str | None:
    try:
        return None if _is_number(value) else ""
    except OverflowError:
        return "it is beyond all floats."


def _quantity_problem(value: object) -> str | None:
    """Of a number, or of a text whose unit is looked at where the one that is needed is known."""
    if not isinstance(value, str):
        return _number_problem(value)
    if not value.isprintable():  # YAML would write another text
        return _text_problem(value)
    parts = QUANTITY.fullmatch(value)
    if parts is None or not math.isfinite(float(parts[1])):
        return ""
    try:
        pint_form(parts[2] or "1")
    except ValueError:
        return f"{shown(parts[2])} is no unit; write products of powers, such as kg m^2 or N m/rad."
    return None


def _seconds_problem(value: object) -> str | None:
    if not isinstance(value, str) or not value.isprintable():
        return _quantity_problem(value)
    try:
        number_in(value, "s")
    except QuantityError as error:
        return str(error)
    return None


def _condition_problem(value: object) -> str | None:
    if not isinstance(value, str) or not value.isprintable():
        return _text_problem(value)
    try:
        parts = read_condition(value)
    except QuantityError as error:
        return str(error)
    return _quantity_problem(parts.value)


def choice(words: tuple[str, ...]) -> Scalar:
    """One of some words."""

    def problem(value: object) -> str | None:
        if isinstance(value, str) and value in words:
            return None
        return unknown("word", value, words)

    return Scalar(", ".join(words), {"enum": list(words)}, problem)


def count(least: int) -> Scalar:
    """A whole number."""

    def problem(value: object) -> str | None:
        return None if type(value) is int and least <= value < 1 << 62 else ""

    form = {"type": "integer", "minimum": least}
    return Scalar(f"a whole number from {least} on", form, problem)


TEXT = Scalar("a text", {"type": "string", "minLength": 1}, _text_problem)
NUMBER = Scalar("a finite number", {"type": "number"}, _number_problem)
FLAG = Scalar(
    "true or false", {"type": "boolean"}, lambda value: None if type(value) is bool else ""
)
_WITH_UNIT = {
    "anyOf": [{"type": "number"}, {"type": "string", "pattern": f"^{_NUMBER_WITH_UNIT}$"}]
}
QUANTITY_KIND = Scalar(
    'a finite number, or a text of a number and its unit, such as "1.2 m"', _WITH_UNIT,
    _quantity_problem,
)  # fmt: skip
SECONDS = Scalar(
    'a finite number of seconds, or a text such as "20 ms"', _WITH_UNIT, _seconds_problem
)
CONDITION = Scalar(
    'a condition "SERIES > VALUE", or with <, such as "body.x > 3"',
    {"type": "string", "pattern": FORM}, _condition_problem,
)  # fmt: skip
