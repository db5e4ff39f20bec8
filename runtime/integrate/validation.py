"""Refusal of what cannot be integrated, all problems at once."""

import math
from typing import Any

import numpy as np

from codegen.errors import InputError
from runtime.core.kernel_abi import find_stand_in
from runtime.core.system import System
from runtime.integrate.method import EXPLICIT, IMPLICIT, METHODS, alternatives
from runtime.integrate.problem import Options, Problem

CORRECTIONS = ("step", "stage", "projection", "baumgarte", "hybrid")
_MOST = 2**62  # safety: largest count that is accepted, half the range of an int64


def check(system: System, problem: Problem, options: Options) -> None:
    """Raise `InputError` with everything that is wrong with a problem and its options."""
    problems = [
        *_of_problem(system.coordinates, problem),
        *_of_choices(options),
        *_of_derivatives(system, options),
        *_of_tolerances(system.coordinates, options),
        *_of_instants(problem, options),
        *_of_numbers(options),
    ]
    if problems:
        raise InputError(problems)


def _of_problem(n: int, problem: Problem) -> list[str]:
    problems = []
    for name in ("q", "v", "scale"):
        values = np.asarray(getattr(problem, name))
        if values.shape != (n,):
            problems.append(f"{name} has shape {values.shape}; it must be ({n},).")
        elif not np.all(np.isfinite(values)):
            problems.append(f"{name} has entries that are not finite numbers: {values}.")
    problems += _positive("sizes", problem.sizes, n)
    if not (math.isfinite(problem.t0) and problem.t0 <= problem.t_end < math.inf):
        problems.append(f"The run must not end (t_end = {problem.t_end}) before t0 = {problem.t0}.")
    return problems


def _of_choices(options: Options) -> list[str]:
    problems = []
    if options.method not in METHODS:
        problems.append(
            f"method {options.method!r} is none of the methods; choose one of {', '.join(METHODS)}."
        )
    if options.correction not in CORRECTIONS:
        problems.append(
            f"correction = {options.correction!r} must be one of {', '.join(CORRECTIONS)}."
        )
    return problems


def _of_derivatives(system: System, options: Options) -> list[str]:
    if options.method in IMPLICIT and system.accelerations_tangent is find_stand_in(
        "accelerations_tangent"
    ):
        without = (
            f"method {options.method!r} needs the derivatives of the kernels, and this system has "
            f"none: give it accelerations_tangent and correction_tangent, which "
            f"runtime.load(...).mechanism.tangents has, or choose {alternatives(EXPLICIT)}."
        )
        return [without]
    return []


def _of_tolerances(n: int, options: Options) -> list[str]:
    problems = []
    if not (_is_number(options.rtol) and 1e-15 <= options.rtol <= 1.0):
        problems.append(f"rtol = {options.rtol} must lie between 1e-15 and 1.")
    same = options.atol_q is options.atol_v
    for name, given in (
        ("atol" if same else "atol_q", options.atol_q),
        ("atol_v", None if same else options.atol_v),
    ):
        if given is not None:
            problems += _positive(name, given, n)
    return problems


def _of_instants(problem: Problem, options: Options) -> list[str]:
    if options.t_eval is None:
        return []
    instants = np.asarray(options.t_eval, dtype=np.float64)
    if instants.ndim != 1 or not np.all(np.diff(instants) >= 0.0):
        return ["t_eval must be a row of ascending times."]
    if instants.size and not problem.t0 <= instants[0] <= instants[-1] <= problem.t_end:
        outside = (
            f"t_eval runs from {instants[0]} to {instants[-1]}; it must lie between t0 = "
            f"{problem.t0} and t_end = {problem.t_end}."
        )
        return [outside]
    return []


def _of_numbers(options: Options) -> list[str]:
    problems = []
    for name in ("first_step", "h_max", "h_min", "fixed_step", "time_scale"):
        length = getattr(options, name)
        if length is not None and not (_is_number(length) and 0.0 < length < math.inf):
            problems.append(f"{name} = {length} must be a positive, finite number of seconds.")
    for name in ("max_steps", "max_events", "chunk"):
        count = getattr(options, name)
        if name == "chunk" and count is None:
            continue
        whole = isinstance(count, int | np.integer) and not isinstance(count, bool)
        if not (whole and 1 <= count <= _MOST):
            problems.append(f"{name} = {count} must be a whole number from 1 to {_MOST}.")
    return problems


def _positive(name: str, given: Any, n: int) -> list[str]:
    """Complain unless there is one finite positive number, or n of them."""
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        return [f"{name} = {given!r} must be positive, one number or {n}."]
    if values.shape in ((), (n,)) and np.all((values > 0.0) & (values < np.inf)):
        return []
    return [f"{name} = {values} must be positive and finite, one number or {n}."]


def _is_number(given: Any) -> bool:
    return isinstance(given, int | float | np.integer | np.floating) and not isinstance(given, bool)
