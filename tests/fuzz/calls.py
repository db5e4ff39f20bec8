"""Calls of the runtime's public functions with arguments of the wrong kind, from a seed.

A call takes one to three arguments of kinds that mean nothing there. It must be refused by an error
of Linkwright's own that says which argument it was, soon, and without warnings; a kind that an
argument accepts is written down here.
"""

import traceback
import warnings
from collections.abc import Callable
from inspect import signature
from pathlib import Path
from random import Random
from time import monotonic
from typing import Any, NamedTuple

from codegen import build
from codegen.errors import LinkwrightError
from runtime import accuracy, animate, load, load_result, load_study, matters, sweep
from runtime.machine_facade import Machine
from tests.fuzz.nonsense import KINDS, NUMBERS, POSITIVE, TEXTS

UNKNOWN = 0.03  # part of the calls with an argument that there is not
SLOW = 20.0  # seconds after which a call counts as hanging
NONE = {"none"}
PATHS = {"text", "number as text", "newline", "code", "path-like text", "path"}
FUNCTIONS = {"function"}
NAMELESS = {"Assembly[]", "Table.index", "Result.plot"}  # calls whose arguments have no names


class Call(NamedTuple):
    """A function, its good arguments, and the kinds that each argument accepts."""

    title: str
    function: Callable[..., Any]
    good: dict[str, Any]
    accepts: dict[str, set[str]]


class Case(NamedTuple):
    """A call with arguments replaced by values of the kinds that it names."""

    call: Call
    kinds: dict[str, str]

    def __str__(self) -> str:
        return f"{self.call.title}({', '.join(f'{k}: {v}' for k, v in self.kinds.items())})"


def calls(free: Machine, driven: Machine) -> list[Call]:
    """Public functions: of a machine that moves freely, of one that is driven, of their results."""
    result = free.simulate(0.01, [0.0, 0.01], progress=False)
    assembly = free.assemble()
    name, joint = free.coordinates.names[0], free.constraints[0].element
    values = {"parameters": NONE, "guess": NONE}
    begins = {**values, "start": NONE}
    of_run = {
        **begins, "t_end": POSITIVE | {"zero"}, "t_eval": NONE | {"zero"},
        "t_start": {"zero", "minus"},
        "rtol": NONE | POSITIVE, "correction": set(), "formulation": NONE,
        "atol": NONE | POSITIVE | {"list", "tuple", "array"}, "quantities": NONE, "method": NONE,
        **dict.fromkeys(("time_scale", "first_step", "max_step"), NONE | POSITIVE),
        "max_steps": NONE | {"one", "data array"}, "progress": {"true"},
    }  # fmt: skip
    accuracies = {"accuracy": NONE | POSITIVE, "quantities": NONE}
    studied = {
        "model": set(), "scene": NONE, "folder": NONE | PATHS, **begins, "t_start": NUMBERS,
        "t_end": NUMBERS | NONE, "progress": FUNCTIONS,
    }  # fmt: skip
    wrong = {"model": str(free.path), "scene": "abc", "t_end": 1.0}
    flags = {name: {"true"} for name in ("tangents", "reduced", "check", "compile")}
    several = ("quantities", "methods", "formulations", "beside")
    of_accuracy = {name: {"empty list"} for name in several}
    target = {"t_end": 0.01, "accuracy": 1e-4}
    described = [
        Call("simulate", free.simulate, {"t_end": 0.01}, of_run),
        Call("simulate to an accuracy", free.simulate, target, accuracies),
        Call("assemble", free.assemble, {}, {**begins, "t": NUMBERS}),
        Call("initial_modes", free.initial_modes, {}, {"t": NUMBERS, "parameters": NONE}),
        Call("parameter_values", free.parameter_values, {}, {"overrides": NONE}),
        Call(
            "equilibrium", free.equilibrium, {},
            {**values, "t": NUMBERS, "method": set(), "progress": {"true"}},
        ),
        Call("Result.plot", result.plot, {"name": name}, {"name": set()}),
        Call("Result.save", result.save, {"path": "a.csv"}, {"path": set()}),
        Call("Result.animate", result.animate, {}, {
            **dict.fromkeys(("file", "frames_per_second", "width", "speed", "span"), NONE),
            "progress": {"true"},
        }),
        Call("animate", animate, {"results": [result]},
             {"results": set(), "file": NONE, "labels": {"empty list"}}),
        Call("Result.reaction", result.reaction, {"joint": joint, "component": "fx"},
             {"joint": set(), "component": set()}),
        Call("Result.at", result.at, {"t": 0.005}, {"t": NUMBERS, "side": NONE}),
        Call("Result.state", result.state, {"t": 0.005}, {"t": NUMBERS | NONE, "side": NONE}),
        Call("Result.resume", result.resume, {"t_end": 0.02}, {
            "t_end": POSITIVE, "t_eval": NONE, "max_steps": NONE | {"one", "data array"},
            "progress": {"true"},
        }),
        Call("load_result", load_result, {"path": "a.nc"}, {"path": set(), "machine": NONE}),
        Call("load_study", load_study, {"path": "a.zarr"}, {"path": set(), "machine": NONE}),
        Call("sweep", sweep, {**wrong, "over": ["a=1,2"], "quantities": ["total"],
                              "out": "a.zarr", "workers": 0}, {
            **studied, "over": set(), "quantities": TEXTS, "out": PATHS,
            "progress": {"true"}, "resume": {"true"}, "workers": NONE | {"one", "zero"},
            "seed": NONE | {"one", "zero"}, "count": NONE | {"one"}, "points": set(),
            "keep": {"empty list"}, "sample": NONE, "analysis": NONE, "scheduler": NONE,
        }),
        Call("Assembly[]", assembly.__getitem__, {"name": name}, {"name": set()}),
        Call("Table.index", free.coordinates.index, {"item": name}, {"item": set()}),
        Call("load", load, {"model": "hard/pendulum"},
             {"model": set(), "scene": NONE, "folder": NONE | PATHS}),
        Call("matters", matters, {**wrong, "asked": "kinetic"}, {
            **studied, "asked": TEXTS | FUNCTIONS, "error": NUMBERS | NONE, "fidelities": {"true"},
            "analysis": NONE | TEXTS, "method": TEXTS, "rtol": NUMBERS, "points": NUMBERS,
            "rounds": NUMBERS | NONE,
        }),
        Call("accuracy", accuracy, wrong, {
            **studied, **of_accuracy, "rtols": NONE, "points": NUMBERS, "limit": NUMBERS,
            "steps": NUMBERS, "reference": NONE | PATHS, "building": NONE | {"true"},
            "modelling": {"true"}, "quick": {"true"},
        }),
        Call("build", build, {"model": "abc", "compile": False},
             {"model": set(), "scene": NONE, "out": NONE | PATHS, "settings": NONE,
              "progress": FUNCTIONS, **flags}),
    ]  # fmt: skip
    lookups = ("q", "v", "a", "y", "mode", "share", "power", "work", "point", "energy", "series")
    for lookup in lookups:
        function = getattr(result, lookup)
        parameter = next(iter(signature(function).parameters))
        described.append(Call(f"Result.{lookup}", function, {parameter: name}, {parameter: set()}))
    for analysis in ("kinematics", "inverse_dynamics"):
        times = NUMBERS | {"list", "tuple", "array", "range"}
        accepts = {**begins, "t_eval": times, "t_start": NUMBERS, "progress": {"true"}}
        accepts["t_end"] = NUMBERS | NONE
        described.append(Call(analysis, getattr(driven, analysis), {"t_eval": [0.0]}, accepts))
    return described


def case(described: list[Call], draw: Random) -> Case:
    """A random case."""
    call = draw.choice(described)
    arguments = draw.sample(
        sorted(call.accepts), min(draw.choice((1, 1, 1, 2, 3)), len(call.accepts))
    )
    if draw.random() < UNKNOWN and call.title not in NAMELESS:
        arguments = [draw.choice(("foo", "a b", "T_end", "\n", "__class__"))]
    return Case(call, {name: draw.choice(list(KINDS)) for name in arguments})


def fault(case: Case) -> str:
    """What is wrong with the answer to a case; nothing if it is refused as it should be."""
    call, kinds = case
    given = {name: KINDS[kind]() for name, kind in kinds.items()}
    began = monotonic()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            if call.title in NAMELESS:
                call.function(*(call.good | given).values())
            else:
                call.function(**call.good | given)
    except LinkwrightError as error:
        if not error.problems or not all(problem.strip() for problem in error.problems):
            return "an error without a sentence"
    except Exception as error:
        if "progress=" in "".join(getattr(error, "__notes__", ())):  # a user's own way to end
            return ""
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {error} at {Path(frame.filename).name}:{frame.lineno}"
    else:
        odd = [name for name, kind in kinds.items() if kind not in call.accepts.get(name, set())]
        if odd:
            return f"accepted {', '.join(odd)}"
    spent = monotonic() - began
    return f"took {spent:.0f} s" if spent > SLOW else ""


def judge(random: Random, described: list[Call]) -> str | None:
    """What is wrong about the answer to one case; None: nothing."""
    drawn = case(described, random)
    found = fault(drawn)
    return f"{found}\n    {drawn}" if found else None
