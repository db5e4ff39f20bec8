"""Refusal of what cannot be integrated, all problems at once."""

import math
from collections.abc import Iterator
from typing import Any, get_args

import numpy as np

from codegen.errors import InputError
from runtime.core.kernel_abi import find_stand_in
from runtime.core.system import System
from runtime.integrate.method import EXPLICIT, IMPLICIT, METHODS, alternatives
from runtime.integrate.problem import STABILIZING, Correction, Options, Problem

CORRECTIONS: tuple[str, ...] = get_args(Correction)
_MOST = 2**62  # safety: largest count that is accepted, half the range of an int64


def check(system: System, problem: Problem, options: Options) -> None:
    """Raise `InputError` with everything that is wrong with a problem and its options."""
    problems = [
        *_check_problem(system.coordinates, problem),
        *_check_choices(system, options),
        *_check_tolerances(system.coordinates, options),
        *_check_instants(problem, options),
        *_check_numbers(options),
    ]
    if problems:
        raise InputError(problems)


def _check_problem(n: int, problem: Problem) -> Iterator[str]:
    for name in ("q", "v", "scale"):
        values = np.asarray(getattr(problem, name))
        if values.shape != (n,):
            yield f"{name} has shape {values.shape}; it must be ({n},)."
        elif not np.all(np.isfinite(values)):
            yield f"{name} has entries that are not finite numbers: {values}."
    yield from _check_positive("sizes", problem.sizes, n)
    if not (math.isfinite(problem.t0) and problem.t0 <= problem.t_end < math.inf):
        yield (
            f"The run must not end (t_end = {problem.t_end}) before t0 = {problem.t0} s, where it "
            "begins, as t_start or the state of start= says. Give a later t_end."
        )


def _check_choices(system: System, options: Options) -> Iterator[str]:
    method, tangent = options.method, "accelerations_tangent"
    if method not in METHODS:
        yield f"method {method!r} is none of the methods; choose one of {', '.join(METHODS)}."
    if options.correction not in CORRECTIONS:
        yield f"correction = {options.correction!r} must be one of {', '.join(CORRECTIONS)}."
    if method in IMPLICIT and system.accelerations_tangent is find_stand_in(tangent):
        yield (
            f"method {method!r} needs the derivatives of the kernels, and this system has "
            f"none: give it accelerations_tangent and correction_tangent, which "
            f"runtime.load(...).mechanism.tangents has, or choose {alternatives(EXPLICIT)}."
        )


def _check_tolerances(n: int, options: Options) -> Iterator[str]:
    if not (_is_number(options.rtol) and 1e-15 <= options.rtol <= 1.0):
        yield f"rtol = {options.rtol} must lie between 1e-15 and 1."
    tolerances = {"atol_q": options.atol_q, "atol_v": options.atol_v}
    if options.atol_q is options.atol_v:
        tolerances = {"atol": options.atol_q}
    for name, tolerance in tolerances.items():
        if tolerance is not None:
            yield from _check_positive(name, tolerance, n)


def _check_instants(problem: Problem, options: Options) -> Iterator[str]:
    if options.t_eval is None:
        return
    instants = np.asarray(options.t_eval, dtype=np.float64)
    if instants.ndim != 1 or not np.all(np.diff(instants) >= 0.0):
        yield "t_eval must be a row of ascending times."
    elif instants.size and not problem.t0 <= instants[0] <= instants[-1] <= problem.t_end:
        yield (
            f"t_eval runs from {instants[0]} to {instants[-1]}; it must lie between t0 = "
            f"{problem.t0} and t_end = {problem.t_end}."
        )


def _check_numbers(options: Options) -> Iterator[str]:
    for name in ("first_step", "h_max", "h_min", "fixed_step", "time_scale"):
        length = getattr(options, name)
        if length is not None and not (_is_number(length) and 0.0 < length < math.inf):
            yield f"{name} = {length} must be a positive, finite number of seconds."
    if options.time_scale is not None and options.correction not in STABILIZING:
        yield (
            f"time_scale = {options.time_scale} is the time of Baumgarte's stabilisation, and "
            f"correction={options.correction!r} has none: leave it out, or give "
            'correction="baumgarte" or "hybrid".'
        )
    for name in ("max_steps", "max_bytes", "max_events", "chunk"):
        count = getattr(options, name)
        if name in ("max_steps", "chunk") and count is None:
            continue
        whole = isinstance(count, int | np.integer) and not isinstance(count, bool)
        if not (whole and 1 <= count <= _MOST):
            yield f"{name} = {count} must be a whole number from 1 to {_MOST}."


def _check_positive(name: str, given: Any, n: int) -> Iterator[str]:
    """Complain unless there is one finite positive number, or n of them."""
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        yield f"{name} = {given!r} must be positive, one number or {n}."
        return
    if not (values.shape in ((), (n,)) and np.all((values > 0.0) & (values < np.inf))):
        yield f"{name} = {values} must be positive and finite, one number or {n}."


def _is_number(given: Any) -> bool:
    return isinstance(given, int | float | np.integer | np.floating) and not isinstance(given, bool)
