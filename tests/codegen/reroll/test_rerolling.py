"""Kernels in loops: what is written computes the program, and does not grow with the machine."""

import math
from functools import cache

import numba
import numpy as np
import pytest

from benchmarks.chain import chain
from codegen.derive.equations import derive
from codegen.driver import valid_scenes
from codegen.emit.argument_docstrings import Arguments
from codegen.emit.rolled_kernel import RolledKernelText
from codegen.emit.sincos_function import FUNCTION
from codegen.emit.unrolling import kernel_texts
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.scene_kernels import Lowered, lower
from codegen.lower.program import Kernel
from codegen.reroll.rerolling import reroll
from models.hard.n_four_bar import n_four_bar
from models.hard.spring_chain import model as spring_chain

CLOSE = 1e-12  # of the largest output: sums of a few hundred terms


@cache
def lowered(family: str, size: int) -> Lowered:
    """A machine of so many parts."""
    if family == "spring_chain":
        model, scene = spring_chain, valid_scenes(spring_chain, None)[0]
    else:
        model = chain(size) if family == "chain" else n_four_bar(size)
        scene = valid_scenes(model, None)[0]
    return lower(derive(model, scene))


def rolled_text(machine: Lowered, kernel: Kernel) -> RolledKernelText:
    program, arguments = machine.program, Arguments.of(machine.description)
    texts = kernel_texts(program, arguments, "never")
    text = next(text for text in texts if text.kernel.name == kernel.name)
    assert isinstance(text, RolledKernelText)
    return text


def run(machine: Lowered, kernel: Kernel) -> tuple[dict[str, dict[int, float]], dict[str, object]]:
    """What the text stores, by Python instead of machine code, and the arguments it was given."""
    text, program = rolled_text(machine, kernel), machine.program
    lines = [*text.table_lines(), *FUNCTION.split("\n"), *text.lines()]
    plain = "\n".join(line for line in lines if not line.startswith("@"))
    space: dict[str, object] = {"math": math, "np": np, "numba": numba, "WEAK_PIVOT": 1e-9}
    exec(compile(plain, kernel.name, "exec"), space)
    function = space[kernel.name]
    assert callable(function)
    random, description = np.random.default_rng(7), machine.description
    n, declared = len(description.coordinates), len(description.parameters)
    p = np.zeros(declared + len(program.constants) + text.workspace)
    p[:declared] = [row[1] for row in description.parameters]
    given: dict[str, object] = {"t": 0.3, "p": p}
    given |= {name: random.normal(size=n) for name in ("q", "v", "a")}
    given |= {"w": np.ones(n), "lam": random.normal(size=max(1, len(description.constraints)))}
    given["modes"] = random.integers(0, 2, max(1, len(description.switches)))
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


@pytest.mark.parametrize("family", ["chain", "n_four_bar", "spring_chain"])
def test_the_text_of_every_kernel_computes_the_program(family: str) -> None:
    machine = lowered(family, 7)
    for kernel in machine.program.kernels:
        found, given = run(machine, kernel)
        errors = (ValueError, ZeroDivisionError, OverflowError)
        expected = evaluate(machine.program, kernel.name, given, math, errors)
        assert found.keys() == expected.keys()
        for array, values in expected.items():
            wanted = np.array([float(values[slot]) for slot in values])
            stored = np.array([float(found[array][slot]) for slot in values])
            size = max(1e-300, float(np.abs(wanted).max()))
            assert np.abs(stored - wanted).max() <= CLOSE * size, (kernel.name, array)


def statements_and_entries(family: str, size: int, name: str) -> tuple[int, int]:
    machine = lowered(family, size)
    program, arguments = machine.program, Arguments.of(machine.description)
    slots, kernel = arguments.slots(program), machine.kernels[name]
    base = arguments.declared + len(program.constants)
    rolled = reroll(program, kernel, {k: slots[k] for k in program.hoisted(kernel)}, base)
    text = RolledKernelText(program, kernel, rolled, arguments)
    entries = sum(len(t.columns) * len(t.columns[0]) for t in text.tables if t.columns)
    return rolled.statements, entries


@pytest.mark.parametrize("name", ["accelerations", "correction", "constraints", "reactions"])
@pytest.mark.parametrize("family", ["chain", "n_four_bar"])
def test_code_does_not_grow_and_tables_grow_linearly(family: str, name: str) -> None:
    """From 24 to 48 parts: the same statements, tables with one more row a part.

    Below, another elimination may be the cheapest, whose code is not longer.
    """
    (few, one), (same, two), (many, three) = (
        statements_and_entries(family, size, name) for size in (12, 24, 48)
    )
    assert few <= 1.1 * same
    assert many <= 1.1 * same
    assert three - two <= 2.2 * (two - one) + 60


def test_the_choice_between_loops_and_straight_code() -> None:
    small, large = lowered("chain", 7), lowered("chain", 48)
    for machine, unroll, is_rolled in (
        (small, "auto", False),
        (small, "never", True),
        (large, "auto", True),
        (large, "always", False),
    ):
        arguments = Arguments.of(machine.description)
        texts = kernel_texts(machine.program, arguments, unroll)  # type: ignore[arg-type]
        (text,) = [text for text in texts if text.kernel.name == "accelerations"]
        assert isinstance(text, RolledKernelText) == is_rolled, unroll


def test_the_code_of_a_module_does_not_grow() -> None:
    """From 40 to 80 loops all kernels together: the same lines, but for tables."""
    lines = []
    for size in (40, 80):
        machine = lowered("n_four_bar", size)
        texts = kernel_texts(machine.program, Arguments.of(machine.description), "auto")
        lines.append(sum(len(text.lines()) for text in texts))
    assert lines[1] <= 1.05 * lines[0]
