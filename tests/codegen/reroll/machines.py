"""Machines of many equal parts, and what the texts of their kernels in loops compute."""

import math
from functools import cache

import numba
import numpy as np

from benchmarks.chain import chain
from codegen import Model
from codegen.derive.equations import derive
from codegen.emit.kernel import Arguments
from codegen.emit.module_functions import SIN_COS_FUNCTION
from codegen.emit.rolled_kernel import RolledKernelText
from codegen.lower.interpreter import evaluate
from codegen.lower.lowered_scene import Lowered, lower
from codegen.lower.program import Kernel
from codegen.reading.scene_selection import valid_scenes
from codegen.reroll.batching import Batching
from codegen.reroll.rerolling import Rerolling
from models.hard.n_four_bar import n_four_bar
from models.hard.roller_chain import roller_chain
from models.hard.spring_chain import model as spring_chain

Rolling = type[Rerolling] | type[Batching]


def tree(depth: int) -> Model:
    """Bars that hang on one another, two on each, `depth` bars from the root to a leaf."""
    model = Model(f"tree_{depth}", gravity=(0, -9.81))
    start, guess = {}, {}
    ends = [(model.ground.at(0, 0), "bar")]
    for level in range(depth):
        following = []
        for end, name in ends:
            bar = model.body(name, mass=1.0, inertia=1 / 12)
            model.revolute(f"hinge_{name}", end, bar.at(-0.5, 0))
            start |= {bar.phi: -0.3, bar.omega: 0.0}
            guess |= {bar.x: level + 0.5, bar.y: 0.0}
            following += [(bar.at(0.5, 0.1), f"{name}_a"), (bar.at(0.5, -0.1), f"{name}_b")]
        ends = following
    model.scene("let_go", ["gravity"], start=start, guess=guess)
    return model


def net(side: int) -> Model:
    """Particles on a square lattice, each at a distance of 1 m from its neighbours."""
    model = Model(f"net_{side}", gravity=(0, -9.81))
    particles = {}
    for i in range(side):
        for j in range(side):
            one = particles[i, j] = model.particle(f"p_{i}_{j}", mass=0.1)
            if i:
                model.distance(f"across_{i}_{j}", particles[i - 1, j], one, 1.0)
            if j:
                model.distance(f"down_{i}_{j}", particles[i, j - 1], one, 1.0)
    guess = {b.x: 1.0 * i for (i, _), b in particles.items()}
    guess |= {b.y: -1.0 * j for (_, j), b in particles.items()}
    model.scene("let_go", ["gravity"], guess=guess)
    return model


FAMILIES = {
    "chain": chain,
    "n_four_bar": n_four_bar,
    "roller_chain": roller_chain,
    "tree": tree,
    "net": net,
}


@cache
def lowered(family: str, size: int) -> Lowered:
    """A machine of so many parts."""
    model = spring_chain if family == "spring_chain" else FAMILIES[family](size)
    return lower(derive(model, valid_scenes(model, None)[0]))


def rolled_text(machine: Lowered, kernel: Kernel, rolling: Rolling) -> RolledKernelText:
    """The text of a kernel in loops or in batches."""
    program, arguments = machine.program, Arguments.of(machine.description)
    slots = arguments.slots(program)
    given = program, kernel, {k: slots[k] for k in program.hoisted(kernel)}
    return RolledKernelText(program, kernel, rolling(*given).rolled(), arguments)


def run(
    machine: Lowered, kernel: Kernel, rolling: Rolling, least_mode: int
) -> tuple[dict[str, dict[int, float]], dict[str, object]]:
    """What the text stores, by Python instead of machine code, and the arguments it was given.

    Modes are drawn from `least_mode` and 1.
    """
    text, program = rolled_text(machine, kernel, rolling), machine.program
    lines = [*text.table_lines(), *SIN_COS_FUNCTION.split("\n"), *text.lines()]
    plain = "\n".join(line for line in lines if not line.startswith("@"))
    space: dict[str, object] = {"math": math, "np": np, "numba": numba, "WEAK_PIVOT": 1e-9}
    exec(compile(plain, kernel.name, "exec"), space)
    function = space[kernel.name]
    assert callable(function)
    random, description = np.random.default_rng(7), machine.description
    n, declared = len(description.coordinates), len(description.parameters)
    p = np.zeros(declared + len(program.constants))
    p[:declared] = [row[1] for row in description.parameters]
    given: dict[str, object] = {"t": 0.3, "p": p}
    given |= {name: random.normal(size=n) for name in ("q", "v", "a")}
    given |= {"w": np.ones(n), "lam": random.normal(size=max(1, len(description.constraints)))}
    given["modes"] = random.integers(least_mode, 2, max(1, len(description.switches)))
    if kernel.name != "constants":
        values = evaluate(program, "constants", {"p": p}, math)
        for slot, value in values.get("p", {}).items():
            p[slot] = value
    largest = {out.array: 0 for out in kernel.outputs if out.array not in ("return", "p")}
    for out in kernel.outputs:
        if out.array in largest:
            largest[out.array] = max(largest[out.array], out.slot + 1)
    written = {array: np.full(count, np.nan) for array, count in largest.items()}
    answer = function(*(written.get(name, given.get(name, p)) for name in kernel.arguments))
    found: dict[str, dict[int, float]] = {}
    for out in kernel.outputs:
        array = p if out.array == "p" else written.get(out.array)
        found.setdefault(out.array, {})[out.slot] = answer if array is None else array[out.slot]
    return found, given
