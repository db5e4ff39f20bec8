"""Library-wide: an effect left out moves a machine as its coefficient of zero does.

The motions are those of the programs themselves, interpreted: nothing is compiled for a variant
that only this test asks for.
"""

import math
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy

from codegen import Model
from codegen.declare.scene import Scene
from codegen.declare.symbols import Parameter, side
from codegen.derive.equations import EffectEquations, Equations, derive
from codegen.explain.element_times import about_the_start, parameters
from codegen.lower.interpreter import evaluate
from codegen.lower.lowered_scene import Lowered, lower
from codegen.reading.scene_selection import valid_scenes
from tests.codegen.test_absent_effects import MACHINES, library, small_model

WITH_COEFFICIENTS = (
    "engine", "film_follower", "four_bar", "gear_slider", "quick_return", "rack_and_pinion",
    "scotch_yoke", "slider_crank", "watt_six_bar", "web_cutter", "andrews", "belt_block",
    "contact_follower", "crank", "guide_friction", "jump_law", "roller_chain",
)  # fmt: skip
"""Machines of the library with an effect that vanishes with one of their parameters."""
STEPS = 20
TURN = 0.01
"""How far, in rad or m, the fastest acceleration leads from rest in a step or so."""


def vanishes(effect: EffectEquations, zero: dict[sympy.Symbol, sympy.Expr]) -> bool:
    """Whether an effect exerts nothing once a parameter is zero."""
    terms = effect.terms
    forces = [slope for _, slope in (*terms.gradient, *terms.forces)]
    if terms.friction is not None:
        forces.append(terms.friction.grip)
    marks = {side(effect.name): sympy.Symbol("sigma")}
    return bool(forces) and all(f.subs(marks).subs(zero) == 0 for f in forces)


def coefficients(model: Model, scene: Scene) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Parameters that may be zero, and are of nothing but the effects that then vanish."""
    equations = derive(model, scene)
    for parameter in equations.parameters:
        zero = {Parameter(parameter.name, real=True): sympy.S.Zero}
        gone = tuple(e.name for e in equations.effects if vanishes(e, zero))
        if parameter.sign == "positive" or not gone:
            continue
        (bare,) = valid_scenes(model, scene.without(*gone))
        if parameter.name in derive(model, bare).unused:
            yield parameter.name, gone


@cache
def cases(machine: str) -> tuple[tuple[Model, Scene, str, tuple[str, ...]], ...]:
    """(model, scene, parameter, the effects that vanish) of a machine."""
    (path,) = (p for p in library(Path(__file__).resolve().parents[2]) if p.stem == machine)
    model = small_model(path)
    return tuple(
        (model, scene, name, gone)
        for scene in valid_scenes(model, None)
        if scene.analysis == "dynamics" and not scene.frozen
        for name, gone in coefficients(model, scene)
    )


Held = dict[sympy.Expr, int] | None
"""Switching function → the mode that it is held in; None: the modes of the state."""


class Motion:
    """A scene's own equations, from its start, in steps of the classical Runge-Kutta method."""

    def __init__(self, equations: Equations, lowered: Lowered, zero: str | None) -> None:
        self.program = lowered.program
        self.p = parameters(equations)
        if zero is not None:
            names = [parameter.name for parameter in equations.parameters]
            self.p[names.index(zero)] = 0.0
        self.switches = [switch.g for switch in equations.switches]

    def rates(self, t: float, y: np.ndarray, held: Held) -> np.ndarray:
        q, v = np.split(y, 2)
        told = {"t": t, "q": q.tolist(), "v": v.tolist(), "p": self.p}
        modes = [] if held is None else [held[g] for g in self.switches]
        if self.switches and held is None:
            found = evaluate(self.program, "switching", told, math)["g"]
            modes = [int(found[k] > 0.0) for k in range(len(self.switches))]
        told = {**told, "modes": modes}
        solved = evaluate(self.program, "accelerations", told, math)
        self.multipliers = np.array(list(solved.get("lam", {}).values()))
        return np.concatenate([v, [solved["a"][k] for k in range(len(v))]])

    def run(self, y: np.ndarray, h: float, held: Held) -> tuple[np.ndarray, np.ndarray]:
        """(steps, 2 n) states, then (steps, m) multipliers: all that a driven machine feels."""
        path, multipliers = [y], []
        for k in range(STEPS if held is None else 2):
            t = k * h
            k1 = self.rates(t, y, held)
            k2 = self.rates(t + h / 2, y + h / 2 * k1, held)
            k3 = self.rates(t + h / 2, y + h / 2 * k2, held)
            k4 = self.rates(t + h, y + h * k3, held)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            path.append(y)
            multipliers.append(self.multipliers)
        return np.array(path), np.array(multipliers)


def patterns(equations: Equations) -> Iterator[Held]:
    """The modes of the states themselves, and what switches effects on that do not act there."""
    yield None
    functions = [switch.g for switch in equations.switches]
    if functions:
        yield dict.fromkeys(functions, 0)
        yield dict.fromkeys(functions, 1)
        for one in functions:
            yield {g: int(g == one) for g in functions}


def test_the_library_has_coefficients_to_try() -> None:
    found = {machine: len(cases(machine)) for machine in MACHINES}
    assert {machine for machine, count in found.items() if count} == {*WITH_COEFFICIENTS}
    assert sum(found.values()) >= len(WITH_COEFFICIENTS)


@pytest.mark.parametrize("machine", WITH_COEFFICIENTS)
def test_left_out_moves_as_a_coefficient_of_zero(machine: str) -> None:
    for model, scene, coefficient, gone in cases(machine):
        moved_alike(model, scene, coefficient, gone)


def moved_alike(model: Model, scene: Scene, coefficient: str, gone: tuple[str, ...]) -> None:
    place = f"{scene.name}, {coefficient}"
    (bare,) = valid_scenes(model, scene.without(*gone))
    whole, rest = (derive(model, s) for s in (scene, bare))
    with_it, without = lower(whole), lower(rest)
    states = about_the_start(without)
    start = np.concatenate([states.q[0], states.v[0]])
    zero, never = Motion(whole, with_it, coefficient), Motion(rest, without, None)
    acting = Motion(whole, with_it, None)
    h = TURN / max(1.0, float(np.abs(zero.rates(0.0, start, None)).max()) ** 0.5)
    effect = 0.0
    for held in patterns(whole):
        runs = (motion.run(start, h, held) for motion in (zero, never, acting))
        for one, other, moved in zip(*runs, strict=True):
            size = np.abs(one).max(initial=0.0) + 1.0
            assert np.abs(one - other).max(initial=0.0) <= 1e-12 * size, place
            effect = max(effect, np.abs(moved - one).max(initial=0.0) / size)
    assert effect > 1e-9, f"{place} does nothing here, so the test would show nothing"
