"""Refined solutions against fifty digits, where masses are far apart."""

import math
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from codegen import Model
from codegen.errors import ModelError
from codegen.lower.constant_hoisting import with_constants
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.accelerations import dynamics_kernel
from codegen.lower.linear.factorization import Strategy
from codegen.lower.program import Program
from codegen.lower.scene_graph import SceneGraph
from codegen.reading.model_file import read_model
from tests.codegen.workbench import Interpreted, State, random_machine

FOLDED = 1e-12
"""What a build folds into numbers, the inverses of pivots too, is rounded to doubles."""

STRATEGIES: tuple[Strategy, ...] = ("substitute", "mixed", "schur", "leaves")


def kernel(machine: Interpreted, strategy: Strategy, refine: bool) -> Program:
    graph = SceneGraph(machine.equations)
    fused = dynamics_kernel(graph, strategy, tuple(range(graph.m)), refine=refine)
    return with_constants(graph.graph, (fused,), len(machine.p))


def solution(program: Program, inputs: Mapping[str, Any], functions: ModuleType | Any) -> list[Any]:
    """(q̈, λ)."""
    out = evaluate(program, "accelerations", inputs, functions)
    return [out[part][k] for part in ("a", "lam") for k in range(len(out.get(part, {})))]


def inputs(s: State, p: list[float], number: Any = float) -> dict[str, Any]:
    return {
        "t": number(s.t),
        "q": [number(float(x)) for x in s.q],
        "v": [number(float(x)) for x in s.v],
        "p": [number(float(x)) for x in p],
        "modes": [0] * 9,
    }


def turned(machine: Interpreted, crank: float) -> State:
    """The linkage with a coupler above the line of centres, on its constraints."""
    s = State(t=0.0, q=np.zeros(machine.n), v=np.zeros(machine.n))
    names = [q.name for q in machine.equations.coordinates]
    drawn = {"coupler_x": 2.0, "coupler_y": 1.4, "coupler_phi": 1.23,
             "rocker_x": 2.5, "rocker_y": 1.4, "rocker_phi": 1.9}  # fmt: skip
    for name, value in drawn.items():
        s.q[names.index(name)] = value
    held = np.ones(machine.n)
    held[names.index("crank_phi")] = 0.0
    s.v[names.index("crank_phi")] = 12.0
    for angle in np.linspace(0.0, crank, 10):
        s.q[names.index("crank_phi")] = angle
        for _ in range(8):
            s = machine.corrected(s, held)
    assert np.abs(machine.vector("constraints", s)).max() < 1e-13
    return s


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("ratio", [1e-8, 1e-4, 1.0, 1e4, 1e8])
def test_accelerations_keep_their_digits(root: Path, strategy: Strategy, ratio: float) -> None:
    machine = Interpreted(read_model(root / "models" / "hard" / "mass_ratio.py").model, "turning")
    plain, refined = (kernel(machine, strategy, refine) for refine in (False, True))
    losses = []
    for crank in (0.4, 1.7, 3.0, 4.4, 5.6):
        s = turned(machine, crank)
        with mp.workdps(50):
            exact = np.array(solution(plain, inputs(s, [ratio], mp.mpf), mp), dtype=object)
        n, largest = machine.n, float(max(abs(exact[: machine.n])))
        off = [
            float(max(abs(np.array(solution(program, inputs(s, [ratio]), math)) - exact)[:n]))
            for program in (plain, refined)
        ]
        assert off[1] < 1e-14 * largest
        losses.append(off[0] / largest)
    # What the order of elimination costs, and that there is something to mend.
    spread = max(ratio, 1.0 / ratio)
    assert max(losses) < 1e-14 * spread
    assert spread < 1e6 or max(losses) > 1e-11


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("seed", range(6))
def test_refined_or_not_it_is_the_same_solution(seed: int, strategy: Strategy) -> None:
    model, s = random_machine(seed, closed=seed % 2 == 0)
    machine = Interpreted(model)
    with mp.workdps(50):
        plain, refined = (
            solution(kernel(machine, strategy, refine), inputs(s, machine.p, mp.mpf), mp)
            for refine in (False, True)
        )
        largest = max(abs(x) for x in plain)
        assert max(abs(x - y) for x, y in zip(plain, refined, strict=True)) < FOLDED * largest


def test_friction_is_refined_with_the_rest(root: Path) -> None:
    model = read_model(root / "models" / "hard" / "guide_friction.py").model
    machine = Interpreted(model, "running_down")
    s = State(t=0.0, q=np.linspace(0.1, 0.9, machine.n), v=np.linspace(-1.0, 1.0, machine.n))
    strategy = machine.lowered.strategy
    assert strategy is not None
    with mp.workdps(50):
        plain, refined = (
            solution(kernel(machine, strategy, refine), inputs(s, machine.p, mp.mpf), mp)
            for refine in (False, True)
        )
        largest = max(abs(x) for x in plain)
        assert max(abs(x - y) for x, y in zip(plain, refined, strict=True)) < FOLDED * largest


def test_only_masses_far_apart_are_refined(root: Path) -> None:
    for path, scene, expected in (
        ("hard/mass_ratio.py", "turning", True),
        ("slider_crank.py", "compressor", False),
    ):
        machine = Interpreted(read_model(root / "models" / path).model, scene)
        (built,) = (k for k in machine.lowered.program.kernels if k.name == "accelerations")
        strategy = machine.lowered.strategy
        assert strategy is not None
        counts = [
            sum(1 for _ in program.reachable(found))
            for program, found in (
                (machine.lowered.program, built),
                *(
                    (p, p.kernels[-1])
                    for p in (kernel(machine, strategy, r) for r in (False, True))
                ),
            )
        ]
        assert counts[1] < counts[2]
        assert (counts[0] - counts[1] > 0.5 * (counts[2] - counts[1])) == expected


@pytest.mark.parametrize("arm", [7e199, 1e160, 1e-200])
def test_arms_that_no_ratio_of_floats_holds_are_refused_with_their_joint(arm: float) -> None:
    model = Model("m")
    model.revolute("mine", model.ground.at(0, 0), model.body("a", 1, 1).at(arm, 0))
    with pytest.raises(ModelError, match=r"'mine_[xy]': masses and moments of inertia at its arms"):
        Interpreted(model)
