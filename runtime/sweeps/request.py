"""The request of a sweep: everything that determines its numbers, and how two requests differ."""

import hashlib
import json
import marshal
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from types import CodeType
from typing import Any

import numpy as np

from codegen import __version__
from codegen.errors import InputError
from codegen.plain_values import one_line
from runtime.results.samples import plain
from runtime.studies.effect_ranking.quantity import Function, Quantity, parse_quantity

PROGRAMS = ("numba", "numpy", "scipy")  # whose versions may change the last bits of a run
_WIDEST = 120  # layout: characters of a value in a message


@dataclass(frozen=True)
class Request:
    """One run of a sweep, but for the values of its factors."""

    model: str
    scene: str
    module: str  # SHA-256 of the generated module's text
    analysis: str  # "simulate", "kinematics", "inverse" or "equilibrium"
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
        """All that determines the numbers, as JSON; `points` is the digest of the design."""
        return {
            "linkwright": __version__,
            **{program: version(program) for program in PROGRAMS},
            "model": f"{self.model}/{self.scene}",
            "generated module": self.module,
            "analysis": self.analysis,
            "points": points,
            "start values": [*self.starts],
            "quantities": {name: described(given) for name, given in self.quantities},
            "series": [*self.keep],
            "t_start": self.t_start,
            "t_end": self.t_end,
            "instants": self.points,
            **{name: dict(getattr(self, name)) for name in ("parameters", "guess", "start")},
            "options": {name: described(value) for name, value in sorted(self.options.items())},
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
    values = (facts[name] for name in ("parameters", "guess", "start", "options"))
    return Request(
        model, scene, facts["generated module"], facts["analysis"], names,
        tuple(facts["start values"]), tuple(facts["quantities"].items()), tuple(facts["series"]),
        facts["t_start"], facts["t_end"], facts["instants"], *values,
    )  # fmt: skip


def digest_of(facts: Mapping[str, Any]) -> str:
    """SHA-256 of a request's facts."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def described(value: Any) -> Any:
    """A value of a request as JSON; a function by its name and a hash of its code."""
    if callable(value):
        name = getattr(value, "__qualname__", type(value).__name__)
        return f"function {name}, {_code_hash(value)[:16]}"
    if isinstance(value, Mapping):
        return {str(name): described(entry) for name, entry in value.items()}
    if isinstance(value, tuple | list | np.ndarray):
        return [described(entry) for entry in value]
    return plain(value)


def _code_hash(function: Callable[..., Any]) -> str:
    """SHA-256 of a function's code, defaults and captured values."""
    code = getattr(function, "__code__", None)
    parts = [repr(sys.version_info[:2])]
    if code is None:  # an object that is called: its class and its state stand for it
        parts += [type(function).__qualname__, repr(sorted(getattr(function, "__dict__", {})))]
    else:
        cells = getattr(function, "__closure__", None) or ()
        parts += [repr([cell.cell_contents for cell in cells]), repr(function.__defaults__)]
        parts += [marshal.dumps(_anonymous(code)).hex()]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _anonymous(code: CodeType) -> CodeType:
    """The code without the file and line where it stands."""
    inner = tuple(_anonymous(x) if isinstance(x, CodeType) else x for x in code.co_consts)
    return code.replace(co_filename="", co_firstlineno=1, co_linetable=b"", co_consts=inner)


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
        elif name == "points":
            yield "the points: other factors, values, sample, count or seed"
        else:
            yield _changed(name, old, new)


def _changed(name: str, old: object, new: object) -> str:
    shown = ("not given" if x is None else one_line(x, _WIDEST) for x in (old, new))
    return "{} was {} and is {}".format(name, *shown)
