"""The request of a sweep: everything that determines its numbers, and how two requests differ."""

import hashlib
import json
import platform
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen import __version__
from codegen.errors import InputError, LinkwrightError
from codegen.readers.values import one_line
from runtime.results.samples import plain
from runtime.studies.quantity import Function, Quantity, parse_quantity
from runtime.sweeps.value_digest import ContentError, value_digest

_WIDEST = 120  # layout: characters of a value in a message
SOURCES, PROCESSOR = "sources of Linkwright", "processor"


@dataclass(frozen=True)
class Request:
    """One run of a sweep, but for the values of its factors."""

    model: str
    scene: str
    module: str  # SHA-256 of the generated module's text
    analysis: str  # one of `runtime.core.kinds.ANALYSES`
    names: tuple[str, ...]  # of the factors
    starts: tuple[str, ...]  # those of them that are start values; the others are parameters
    quantities: Mapping[str, str | Function]  # by the name of their column
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
    def readers(self) -> dict[str, Quantity]:
        """The quantities, ready to be read from a result."""
        return {name: parse_quantity(given) for name, given in self.quantities.items()}

    def values(self, point: npt.NDArray[np.float64]) -> dict[str, dict[str, float]]:
        """Parameters, guesses and start values of one run, by name."""
        parameters, start = dict(self.parameters), dict(self.start)
        for name, value in zip(self.names, point.tolist(), strict=True):
            (start if name in self.starts else parameters)[name] = value
        values = {"parameters": parameters, "guess": dict(self.guess)}
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
            "quantities": {
                name: description(given, name) for name, given in self.quantities.items()
            },
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
        tuple(facts["start values"]), facts["quantities"], tuple(facts["series"]),
        facts["t_start"], facts["t_end"], facts["instants"], *values,
    )  # fmt: skip


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


def digest_of(facts: Mapping[str, Any]) -> str:
    """SHA-256 of a request's facts."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """A clause for each fact in which two requests differ."""
    for name in dict.fromkeys([*before, *now]):
        old, new = before.get(name), now.get(name)
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            yield from (f"{name}, {clause}" for clause in differences(old, new))
        elif name == "generated module":
            yield "the model: its generated module has another text"
        elif name == SOURCES:
            yield f"the {SOURCES} have another text"
        elif name == "points":
            yield "the points: other factors, values, sample, count or seed"
        else:
            texts = ("not given" if x is None else one_line(x, _WIDEST) for x in (old, new))
            yield "{} was {} and is {}".format(name, *texts)


@cache
def program_facts() -> dict[str, str]:
    """Versions by name, the hash of Linkwright's own sources, and the kind of processor."""
    from codegen.machine_code.code_folders import processor  # which loads numba

    name, _ = processor()
    libraries = ("llvmlite", "numba", "numpy", "scipy")
    return {
        "linkwright": __version__,
        SOURCES: sources_hash(),
        "python": platform.python_version(),
        **{library: version(library) for library in libraries},
        PROCESSOR: f"{platform.machine()} {name}",
    }


def sources_hash() -> str:
    """SHA-256 of the files of Python that this installation has of Linkwright."""
    root = Path(__file__).resolve().parents[2]
    found = hashlib.sha256()
    for package in ("codegen", "runtime"):
        for file in sorted((root / package).rglob("*.py")):
            content = file.read_bytes()
            found.update(f"{file.relative_to(root).as_posix()} {len(content)}\n".encode() + content)
    return found.hexdigest()


def changed_programs(before: Mapping[str, Any]) -> list[str]:
    """A clause for each program that was another one when facts were noted."""
    now = program_facts()
    return [*differences({name: before.get(name, "not noted") for name in now}, now)]


def require_programs(wanted: Mapping[str, Any]) -> None:
    """Refuse to make runs by other programs than the sweep began with.

    The processor may differ, as that of a cluster's computers may.

    Raises
    ------
    LinkwrightError
        With all that differs.
    """
    changes = [x for x in changed_programs(wanted) if not x.startswith(PROCESSOR)]
    if changes:
        raise LinkwrightError(
            f"A worker on {platform.node() or 'another computer'} has other programs than the "
            f"sweep: {'; '.join(changes)}. Install the same ones there, and start it again."
        )
