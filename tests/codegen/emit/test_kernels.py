"""The emitted functions against the interpreter: run by Python, and as machine code."""

import math
from typing import Any

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from codegen.emit.module_functions import SIN_COS
from codegen.lower.interpreter import evaluate
from codegen.lower.program import Kernel
from tests.codegen.workbench import Interpreted, python_functions

Scenes = dict[str, Interpreted]


def inputs(machine: Interpreted, seed: int) -> dict[str, Any]:
    random = np.random.default_rng(seed)
    n, m = machine.n, machine.m
    found: dict[str, Any] = {"t": float(random.uniform(0, 1))}
    for name, size in (("q", n), ("v", n), ("a", n), ("lam", m)):
        found[name] = random.uniform(-1.5, 1.5, size)
    found["w"] = random.uniform(0.5, 2, n)
    found["modes"] = random.integers(0, 2, machine.s)
    declared = [] if machine.equations.scene.frozen else machine.p
    found["p"] = np.array([*declared, *[0.0] * len(machine.program.constants)])
    return found


def called(function: Any, machine: Interpreted, kernel: Kernel, given: dict[str, Any]) -> Any:
    """What a function stores and returns."""
    sizes = {"phi": machine.m, "nu": machine.m, "gamma": machine.m, "lam": machine.m}
    outputs: dict[str, np.ndarray] = {}
    for out in kernel.outputs:
        if out.array not in ("return", "p") and out.array not in outputs:
            count = sum(other.array == out.array for other in kernel.outputs)
            outputs[out.array] = np.full(max(count, sizes.get(out.array, 0)), np.nan)
    arguments = []
    for name in kernel.arguments:
        known = given.get(name, np.zeros(0))
        arguments.append(outputs.get(name, known))
    returned = function(*arguments)
    return returned, outputs


def expected(machine: Interpreted, kernel: Kernel, given: dict[str, Any]) -> dict[str, np.ndarray]:
    plain = {k: x.tolist() if isinstance(x, np.ndarray) else x for k, x in given.items()}
    slots = evaluate(machine.program, kernel.name, plain, math)
    return {k: np.array([x[i] for i in range(len(x))]) for k, x in slots.items()}


def compare(machine: Interpreted, functions: dict[str, Any], exact: bool) -> int:
    compared = 0
    for seed in range(3):
        given = inputs(machine, seed)
        functions["constants"](given["p"])
        for kernel in machine.program.kernels:
            if kernel.name == "constants":
                continue
            returned, outputs = called(functions[kernel.name], machine, kernel, given)
            wanted = expected(machine, kernel, given)
            if "return" in wanted:
                outputs = {"return": np.array([returned])}
            elif kernel.watched:
                assert returned == 0, kernel.name
            else:
                assert returned is None
            assert outputs.keys() == wanted.keys()
            for array, values in wanted.items():
                compared += len(values)
                if exact:
                    assert_array_equal(outputs[array], values, err_msg=kernel.name)
                else:
                    size = np.abs(values).max(initial=1e-300)
                    assert_allclose(
                        outputs[array], values, rtol=1e-9, atol=1e-11 * size, err_msg=kernel.name
                    )
    return compared


def test_text_computes_what_the_program_says(scenes: Scenes, texts: dict[str, str]) -> None:
    for name, machine in scenes.items():
        functions = python_functions(texts[name])
        functions[SIN_COS] = lambda x: (math.sin(x), math.cos(x))  # to the last digit
        count = compare(machine, functions, exact=True)
        assert count > 20, name


def test_constants_follow_the_parameters(scenes: Scenes, texts: dict[str, str]) -> None:
    machine = scenes["names.default"]
    assert len(machine.program.constants) >= 2
    p = [*machine.p, *[0.0] * len(machine.program.constants)]
    python_functions(texts["names.default"])["constants"](p)
    (kernel,) = (k for k in machine.program.kernels if k.name == "constants")
    slots = evaluate(machine.program, "constants", {"p": machine.p}, math)["p"]
    assert [out.slot for out in kernel.outputs] == list(range(len(machine.p), len(p)))
    assert p[len(machine.p) :] == [slots[k] for k in range(len(machine.p), len(p))]


def test_machine_code_computes_what_the_program_says(
    scenes: Scenes, slider_crank: Scenes, compiled: dict[str, Any]
) -> None:
    assert set(compiled) == {*slider_crank, "names.default"}
    for name, module in compiled.items():
        assert compare(scenes[name], vars(module), exact=False) > 20


def test_kernels_have_one_signature_each(compiled: dict[str, Any]) -> None:
    for module in compiled.values():
        for name, _ in module.OPERATIONS:
            assert getattr(module, name).declared is not None


def test_lock_up_is_told_by_the_return_value(scenes: Scenes, compiled: dict[str, Any]) -> None:
    module, machine = compiled["compressor"], scenes["compressor"]
    p = np.array([*machine.p, *[0.0] * len(module.CONSTANTS)])
    p[1] = 2.0  # a rod as long as the crank, and both upright
    module.constants(p)
    q = np.array([0, 0, np.pi / 2, 0, 1, -np.pi / 2, 0, 0, 0])
    phi, a, lam = np.zeros(8), np.zeros(9), np.zeros(8)
    module.constraints(0.0, q, p, phi)
    assert np.abs(phi).max() < 1e-15
    modes = np.zeros(4, dtype=np.int64)
    answer = module.accelerations(0.0, q, np.zeros(9), p, modes, a, lam)
    assert 1 <= answer <= 8
    element, _, _ = module.CONSTRAINTS[answer - 1]
    assert element in {"B", "C", "guide"}
    dq, dv = np.zeros(9), np.zeros(9)
    assert module.correction(0.0, q, np.zeros(9), p, np.ones(9), dq, dv) > 0
