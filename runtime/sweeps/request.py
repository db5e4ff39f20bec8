"""The request of a sweep: everything that determines its numbers; a member's run and its row.

A function of the user's own is known by its code, defaults, captured values, and the globals that
it reads, each by its content, however deep, and a class by its fields. Of an installed library the
file of the module stands for all that is in it. Nothing depends on addresses, on the order of a
set, or on the process.
"""

import dis
import hashlib
import inspect
import platform
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache, cached_property
from importlib.metadata import version
from pathlib import Path
from types import CodeType, FunctionType, MappingProxyType, ModuleType
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel, FiniteFloat, PositiveInt

from codegen import __version__
from codegen.errors import FAILURES, InputError, LinkwrightError
from codegen.files.build_records import source_hash
from codegen.files.library_folders import is_installed
from codegen.readers.values import one_line
from runtime.core.arrays import Matrix, Vector
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.result import Result
from runtime.results.samples import plain
from runtime.studies.quantity import parse_quantity

OK = "OK"  # outcome of a run to its end; other runs have the name of an `Outcome`, or one of these
REFUSED = "REFUSED"
ERROR = "ERROR"
KILLED = "KILLED"
MEMORY = "MEMORY"
FAILED_TO_RUN = {
    REFUSED: "the run was refused: its values make no machine, or no start",
    ERROR: "an exception ended the run",
    KILLED: "the run ended its process, several times",
    MEMORY: "the memory did not suffice",
}
"""Outcome → its meaning; all others are those of `runtime.core.outcomes.Outcome`."""
SOURCES, PROCESSOR = "sources of Linkwright", "processor"
_LONGEST = 2000  # layout: characters of a message that are kept
_WIDEST = 120  # layout: characters of a value in a message
_LONG = 30.0  # safety: s of runs in a task, which are lost with its process
_SAME = 1e-9  # accuracy: share of the run within which an instant is the one that was asked for


class Request(BaseModel, frozen=True):
    """One run of a sweep, but for the values of its factors."""

    model: str  # MODEL/SCENE
    generated_module: str  # SHA-256 of its text, as of the companions, by kind
    companions: dict[str, str]
    analysis: str  # one of `runtime.core.kinds.ANALYSES`
    factors: tuple[str, ...]
    start_values: tuple[str, ...]  # those of the factors that are none of the parameters
    quantities: dict[str, Any]  # texts, or functions of a result, by the name of their column
    series: tuple[str, ...]  # that are kept of each run
    t_start: FiniteFloat  # s
    t_end: FiniteFloat  # s
    instants: PositiveInt
    parameters: dict[str, FiniteFloat]
    guess: dict[str, FiniteFloat]
    start: dict[str, FiniteFloat]
    options: dict[str, Any]  # of `simulate`, those that are given

    def facts(self, points: Matrix) -> dict[str, Any]:
        """All that determines the numbers, as JSON; `points` are (runs, factors).

        Raises InputError if a function refers to what has no content that could be compared.
        """
        digest = hashlib.sha256(np.ascontiguousarray(points).tobytes()).hexdigest()
        own = {name: described(getattr(self, name), name) for name in Request.model_fields}
        return {**program_facts(), "points": digest, **own}


def described(value: Any, name: str) -> Any:
    """A value of a request as JSON; a function by its name and the digest of its content."""
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
        return {str(key): described(entry, str(key)) for key, entry in value.items()}
    if isinstance(value, tuple | list | np.ndarray):
        return [described(entry, name) for entry in value]
    return plain(value)


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """A clause for each fact in which two requests differ."""
    for name in dict.fromkeys([*before, *now]):
        old, new = before.get(name), now.get(name)
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            yield from (f"{name}, {clause}" for clause in differences(old, new))
        elif name == "generated_module":
            yield "the model: its generated module has another text"
        elif name == SOURCES:
            yield f"the {SOURCES} have another text"
        elif name == "points":
            yield "the points: other values, sample, count or seed"
        else:
            texts = ("not given" if x is None else one_line(x, _WIDEST) for x in (old, new))
            yield "{} was {} and is {}".format(name, *texts)


@cache
def program_facts() -> dict[str, str]:
    """Versions by name, the hash of Linkwright's own sources, and the kind of processor."""
    from codegen.machine_code.code_folders import processor  # which loads numba

    return {
        "linkwright": __version__,
        SOURCES: source_hash("codegen", "runtime"),
        "python": platform.python_version(),
        **{library: version(library) for library in ("llvmlite", "numba", "numpy", "scipy")},
        PROCESSOR: f"{platform.machine()} {processor()[0]}",
    }


def changed_programs(before: Mapping[str, Any]) -> list[str]:
    """A clause for each program that was another one when facts were noted."""
    now = program_facts()
    return [*differences({name: before.get(name, "not noted") for name in now}, now)]


def run_member(machine: Machine, request: Request, point: Vector) -> Result:
    """The run of a member, by the same words in every process.

    Raises LinkwrightError if its values make no machine.
    """
    parameters, start = dict(request.parameters), dict(request.start)
    for name, value in zip(request.factors, point.tolist(), strict=True):
        (start if name in request.start_values else parameters)[name] = value
    values: dict[str, Any] = {"parameters": parameters, "guess": request.guess, "progress": False}
    values |= {"start": start} if start else {}
    first, last, count = request.t_start, request.t_end, request.instants
    if request.analysis == "simulate":
        return machine.simulate(last, count, t_start=first, **values, **request.options)
    if request.analysis == "equilibrium":
        return machine.equilibrium(**values, t=first)
    driven = machine.kinematics if request.analysis == "kinematics" else machine.inverse_dynamics
    return driven(np.linspace(first, last, count), **values)


class Rows(NamedTuple):
    """All that is kept of some runs; not a number where there is none."""

    numbers: Vector  # (runs, quantities + 1): the quantities, the instant reached in s
    series: Vector  # (runs, series, instants)
    outcomes: list[str]
    messages: list[str]


def rows_without_runs(request: Request, count: int, outcome: str = "", message: str = "") -> Rows:
    """Rows of members that have no result."""
    numbers = np.full((count, len(request.quantities) + 1), np.nan)
    series = np.full((count, len(request.series), request.instants), np.nan)
    return Rows(numbers, series, [outcome] * count, [message] * count)


def evaluate_members(machine: Machine, request: Request, points: Matrix) -> Rows:
    """Run the members of these points, (runs, factors); every failure is a row.

    Rows of the first ones alone where these take long, or the user stops them.
    """
    rows, made = rows_without_runs(request, len(points)), 0
    end = time.monotonic() + _LONG
    for point, numbers, series in zip(points, rows.numbers, rows.series, strict=True):
        try:
            outcome, message = _evaluate_member(machine, request, point, numbers, series)
        except KeyboardInterrupt:
            if not made:
                raise
            break
        rows.outcomes[made], rows.messages[made] = outcome, one_line(message, _LONGEST)
        made += 1
        if time.monotonic() > end:
            break
    return Rows._make(column[:made] for column in rows)


def _evaluate_member(
    machine: Machine, request: Request, point: Vector, numbers: Vector, series: Vector
) -> tuple[str, str]:
    """Run a member, and write what its row keeps; its outcome and message."""
    try:
        result = run_member(machine, request, point)
    except LinkwrightError as error:
        return REFUSED, str(error)
    except FAILURES as error:
        outcome = MEMORY if isinstance(error, MemoryError) else ERROR
        return outcome, f"{type(error).__name__}: {error}"
    if result.outcome is Outcome.INTERRUPTED:
        raise KeyboardInterrupt  # the wish to stop is no outcome of a member
    outcome, notes = result.outcome.name, [result.message]
    for place, given in enumerate(request.quantities.values() if not result.failed else ()):
        quantity = parse_quantity(given)
        try:
            numbers[place] = quantity.read(result).value
        except InputError as error:
            notes.append(str(error))
        except FAILURES as error:
            outcome = MEMORY if isinstance(error, MemoryError) else outcome
            notes.append(f"{quantity.text}: {type(error).__name__}: {error}")
    if len(result.t):
        numbers[-1] = result.t[-1]
        instants = np.linspace(request.t_start, request.t_end, request.instants)
        span = max(request.t_end - request.t_start, 1e-300)
        nearest = np.rint((result.t - request.t_start) / span * (request.instants - 1)).astype(int)
        near = np.clip(nearest, 0, request.instants - 1)
        there = np.abs(instants[near] - result.t) <= _SAME * span
        for row, name in zip(series, request.series, strict=True):
            with suppress(InputError):  # behind a change of joints a scene may lack the series
                row[near[there]] = result.series(name)[0][there]
    return outcome, "\n".join(notes)


def companion_texts(machine: Machine, kinds: Sequence[str]) -> dict[str, str]:
    """SHA-256 of the companion modules of a machine, by kind; built where they are missing."""
    from codegen.files.generated_modules import companion_path, read_generated, text_hash

    origin, found = machine.mechanism.origin, dict[str, str]()
    assert origin is not None
    for kind in kinds:
        getattr(machine.mechanism, kind)
        found[kind] = text_hash(read_generated(companion_path(origin.path, kind)))
    return found


_PLAIN = (type(None), bool, int, float, complex, str, bytes, range, slice, type(Ellipsis))
_CODE = ("co_argcount", "co_kwonlyargcount", "co_code", "co_names", "co_varnames", "co_freevars")
_NO_CONTENT = {  # fields of a class that decide no value
    *("__dict__", "__weakref__", "__doc__", "__module__", "__qualname__", "_abc_impl"),
    *("__firstlineno__", "__static_attributes__"),
}


class ContentError(TypeError):
    """A value whose content cannot be told; its text names what."""


def value_digest(value: Any) -> str:
    """SHA-256 of a value's content, in hexadecimal.

    Raises ContentError if it refers to what has no content, such as an open file.
    """
    known: dict[int, tuple[Any, str]] = {}  # address → object, kept alive, and its digest
    above: list[int] = []  # addresses of the objects that are being described

    def digest(value: Any) -> str:
        key = id(value)
        if key in above:
            return f"{len(above) - above.index(key)} above"
        if key not in known:
            above.append(key)
            words, parts = _content(value)
            digests = [digest(part) for part in parts]
            if isinstance(value, set | frozenset):
                digests.sort()
            above.pop()
            content = repr((words, digests)).encode("utf-8", "surrogatepass")
            known[key] = value, hashlib.sha256(content).hexdigest()
        return known[key][1]

    try:
        return digest(value)
    except RecursionError:
        raise ContentError("values that lie too deep in one another") from None


def _content(value: Any) -> tuple[tuple[Any, ...], Iterable[Any]]:
    """Words that say what a value is itself, and the values that it consists of."""
    kind = type(value).__qualname__
    if type(value) in _PLAIN:
        return (kind, repr(value)), ()
    if type(value) in (tuple, list, set, frozenset):
        return (kind,), value
    if type(value) in (dict, MappingProxyType):
        return ("dict",), [part for pair in value.items() for part in pair]
    if isinstance(value, CodeType):
        return ("code", *(getattr(value, name) for name in _CODE)), value.co_consts
    if isinstance(value, ModuleType):
        return ("module", *_module_words(value.__name__)), ()
    if callable(getattr(value, "py_func", None)):  # compiled by numba
        return ("compiled",), (value.py_func,)
    if isinstance(value, FunctionType | type):
        return _function(value) if isinstance(value, FunctionType) else _class(value)
    try:
        made = value.__reduce_ex__(4)  # what copies it would be made from
    except Exception as error:
        raise ContentError(
            f"a {kind} of {type(value).__module__}, whose content cannot be told ({error})"
        ) from error
    if isinstance(made, str):  # the name of a global, such as a function of NumPy
        return ("global", made, *_module_words(getattr(value, "__module__", None))), (type(value),)
    contents = ([*one] for one in made[3:5] if one)
    return ("object",), (type(value), *made[:3], *contents)


def _function(value: FunctionType) -> tuple[tuple[Any, ...], Iterable[Any]]:
    cells = []
    for cell in value.__closure__ or ():
        with suppress(ValueError):  # of a variable that is not set yet
            cells.append(cell.cell_contents)
    if not _is_own(value.__module__):
        return ("library", value.__qualname__, *_module_words(value.__module__)), cells
    known = value.__globals__
    read = [(name, known[name]) for name in sorted(_globals_of(value.__code__)) if name in known]
    parts = value.__code__, value.__defaults__, value.__kwdefaults__, cells, read
    return ("function", value.__name__), parts


def _class(value: type) -> tuple[tuple[Any, ...], Iterable[Any]]:
    if not _is_own(value.__module__):
        return ("library", value.__qualname__, *_module_words(value.__module__)), ()
    fields = [(name, _bare(x)) for name, x in vars(value).items() if name not in _NO_CONTENT]
    return ("class", value.__name__), (value.__bases__, fields)


def _bare(value: Any) -> Any:
    """A field of a class without the object that makes it a method, or an attribute."""
    if isinstance(value, staticmethod | classmethod | property | cached_property):
        return [getattr(value, name, None) for name in ("__func__", "fget", "fset", "func")]
    return None if inspect.ismemberdescriptor(value) else value  # of a slot


def _globals_of(code: CodeType) -> set[str]:
    """Names of the globals that a code and those within it read."""
    names = {
        str(step.argval)
        for step in dis.get_instructions(code)
        if step.opname in {"LOAD_GLOBAL", "LOAD_NAME"}
    }
    return names.union(*(_globals_of(x) for x in code.co_consts if isinstance(x, CodeType)))


def _file_of(module: str | None) -> Path | None:
    """The file of a module that is none of Linkwright, whose sources count as a whole."""
    name = module or "builtins"
    file = getattr(sys.modules.get(name), "__file__", None)
    ours = name.partition(".")[0] in {"runtime", "codegen", "linkwright"}
    return None if file is None or ours else Path(file).resolve()


def _module_words(module: str | None) -> tuple[str, ...]:
    """A module's name, and the hash of its file."""
    file = _file_of(module)
    text = file.read_bytes() if file is not None and file.is_file() else b""
    return module or "builtins", hashlib.sha256(text).hexdigest()


def _is_own(module: str | None) -> bool:
    """Whether a module is the user's: neither installed, nor of Python, nor of Linkwright."""
    if module == "__main__" or (module and module not in sys.modules):
        return True
    file = _file_of(module)
    return file is not None and not is_installed(file)
