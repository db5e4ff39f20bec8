"""The request of a sweep: everything that determines its numbers, and how two requests differ."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.readers.values import one_line
from runtime.results.samples import plain
from runtime.studies.quantity import Function, Quantity, parse_quantity
from runtime.sweeps.programs import SOURCES, program_facts
from runtime.sweeps.value_digest import ContentError, value_digest

_WIDEST = 120  # layout: characters of a value in a message


@dataclass(frozen=True)
class Request:
    """One run of a sweep, but for the values of its factors."""

    model: str
    scene: str
    module: str  # SHA-256 of the generated module's text
    analysis: str  # one of `runtime.core.analysis_names.ANALYSES`
    names: tuple[str, ...]  # of the factors
    starts: tuple[str, ...]  # those of them that are start values; the others are parameters
    quantities: tuple[tuple[str, str | Function], ...]  # by the name of their column
    keep: tuple[str, ...]  # series that are kept of each run
    t_start: float  # s
    t_end: float  # s
    points: int  # output instants
    parameters: Mapping[str, float] = field(default_factory=dict)
    guess: Mapping[str, float] = field(default_factory=dict)
    start: Mapping[str, float] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)  # of `simulate`, those that are given
    companions: Mapping[str, str] = field(default_factory=dict)  # SHA-256 of their texts, by kind

    @property
    def readers(self) -> tuple[Quantity, ...]:
        """The quantities, ready to be read from a result."""
        return tuple(parse_quantity(given) for _, given in self.quantities)

    def values(self, point: np.ndarray[Any, np.dtype[np.float64]]) -> dict[str, dict[str, float]]:
        """Parameters, guesses and start values of one run, by name."""
        varied = dict(zip(self.names, point.tolist(), strict=True))
        starts = {name: value for name, value in varied.items() if name in self.starts}
        others = {name: value for name, value in varied.items() if name not in self.starts}
        values = {"parameters": {**self.parameters, **others}, "guess": dict(self.guess)}
        start = {**self.start, **starts}
        return values | ({"start": start} if start else {})

    def facts(self, points: str) -> dict[str, Any]:
        """All that determines the numbers, as JSON; `points` is the digest of the design.

        Raises
        ------
        InputError
            If a function refers to what has no content that could be compared.
        """
        return {
            **program_facts(),
            "model": f"{self.model}/{self.scene}",
            "generated module": self.module,
            "companions": dict(self.companions),
            "analysis": self.analysis,
            "points": points,
            "start values": [*self.starts],
            "quantities": {name: description(given, name) for name, given in self.quantities},
            "series": [*self.keep],
            "t_start": self.t_start,
            "t_end": self.t_end,
            "instants": self.points,
            **{name: dict(getattr(self, name)) for name in ("parameters", "guess", "start")},
            "options": {n: description(value, n) for n, value in sorted(self.options.items())},
        }


def request_of(facts: Mapping[str, Any], names: tuple[str, ...]) -> Request:
    """The request of facts that were stored, for factors of these names.

    Raises
    ------
    InputError
        If its runs took functions of the user's own, which no file keeps.
    """
    controllers = facts["options"].get("controllers")
    if controllers:
        raise InputError(
            f"The runs of this study took functions ({', '.join(controllers)}), which no file "
            "keeps. Repeat the call of sweep with resume=True: it returns the study with them."
        )
    model, _, scene = facts["model"].rpartition("/")
    values = (facts[x] for x in ("parameters", "guess", "start", "options", "companions"))
    return Request(
        model, scene, facts["generated module"], facts["analysis"], names,
        tuple(facts["start values"]), tuple(facts["quantities"].items()), tuple(facts["series"]),
        facts["t_start"], facts["t_end"], facts["instants"], *values,
    )  # fmt: skip


def digest_of(facts: Mapping[str, Any]) -> str:
    """SHA-256 of a request's facts."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def description(value: Any, name: str) -> Any:
    """A value of a request as JSON; a function by its name and the digest of its content.

    Raises
    ------
    InputError
        If a function refers to what has no content that could be compared; it tells the `name`.
    """
    if callable(value):
        function = getattr(value, "__qualname__", type(value).__name__)
        try:
            return f"function {function}, {value_digest(value)[:16]}"
        except ContentError as error:
            raise InputError(
                f"{name}: the function {function} refers to {error}, so that nobody could tell "
                "whether it is the same when the sweep goes on. Let it refer to numbers, texts and "
                "arrays alone."
            ) from error
    if isinstance(value, Mapping):
        return {str(key): description(entry, f"{name}, {key}") for key, entry in value.items()}
    if isinstance(value, tuple | list | np.ndarray):
        return [description(entry, name) for entry in value]
    return plain(value)


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """A clause for each fact in which two requests differ."""
    for name in dict.fromkeys([*before, *now]):
        old, new = before.get(name), now.get(name)
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            for part in dict.fromkeys([*old, *new]):
                if old.get(part) != new.get(part):
                    yield _changed(f"{name}, {part}", old.get(part), new.get(part))
        elif name == "generated module":
            yield "the model: its generated module has another text"
        elif name == SOURCES:
            yield f"the {SOURCES} have another text"
        elif name == "points":
            yield "the points: other factors, values, sample, count or seed"
        else:
            yield _changed(name, old, new)


def _changed(name: str, old: object, new: object) -> str:
    shown = ("not given" if x is None else one_line(x, _WIDEST) for x in (old, new))
    return "{} was {} and is {}".format(name, *shown)
