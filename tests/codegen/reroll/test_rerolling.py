"""Kernels in loops: what is written computes the program, and does not grow with the machine."""

import math

import numpy as np
import pytest

from codegen.emit.argument_docstrings import Arguments
from codegen.emit.rolled_kernel import RolledKernelText
from codegen.emit.unrolling import kernel_texts
from codegen.lower.interpreter import evaluate
from codegen.reroll.batching import batch
from codegen.reroll.rerolling import reroll
from tests.codegen.reroll.machines import Rolling, lowered, rolled_text, run

CLOSE = 1e-12  # of the largest output: sums of a few hundred terms


@pytest.mark.parametrize("least_mode", [0, 1])
@pytest.mark.parametrize("rolling", [reroll, batch])
@pytest.mark.parametrize(
    ("family", "size"),
    [("chain", 7), ("n_four_bar", 7), ("spring_chain", 0), ("roller_chain", 20),
     ("tree", 3), ("net", 3)],
)  # fmt: skip
def test_the_text_of_every_kernel_computes_the_program(
    family: str, size: int, rolling: Rolling, least_mode: int
) -> None:
    machine = lowered(family, size)
    for kernel in machine.program.kernels:
        if "p" not in kernel.arguments:
            continue
        found, given = run(machine, kernel, rolling, least_mode)
        errors = (ValueError, ZeroDivisionError, OverflowError)
        expected = evaluate(machine.program, kernel.name, given, math, errors)
        assert found.keys() == expected.keys()
        for array, values in expected.items():
            wanted = np.array([float(values[slot]) for slot in values])
            stored = np.array([float(found[array][slot]) for slot in values])
            size = max(1e-300, float(np.abs(wanted).max()))
            assert np.abs(stored - wanted).max() <= CLOSE * size, (kernel.name, array)


def statements_and_entries(family: str, size: int, name: str, rolling: Rolling) -> tuple[int, int]:
    machine = lowered(family, size)
    text = rolled_text(machine, machine.kernels[name], rolling)
    entries = sum(len(t.columns) * len(t.columns[0]) for t in text.tables if t.columns)
    return text.rolled.statements, entries


@pytest.mark.parametrize("name", ["accelerations", "correction", "constraints", "reactions"])
@pytest.mark.parametrize("family", ["chain", "n_four_bar"])
def test_code_does_not_grow_and_tables_grow_linearly(family: str, name: str) -> None:
    """From 32 to 64 parts: the same statements, tables with one more row a part.

    Below, another elimination may be the cheapest, whose code is not longer.
    """
    (few, one), (same, two), (many, three) = (
        statements_and_entries(family, size, name, reroll) for size in (16, 32, 64)
    )
    assert few <= 1.1 * same
    assert many <= 1.1 * same
    assert three - two <= 2.2 * (two - one) + 60


@pytest.mark.parametrize("name", ["accelerations", "correction"])
@pytest.mark.parametrize(("family", "sizes"), [("tree", (6, 8)), ("net", (4, 8))])
def test_batches_need_little_code_where_nothing_has_a_period(
    family: str, sizes: tuple[int, int], name: str
) -> None:
    """Four times the parts: the same few kinds of trees, one table row an expression tree.

    Trees of fewer than 63 bars are eliminated in another order, whose code is shorter.
    """
    few, many = (statements_and_entries(family, size, name, batch) for size in sizes)
    assert many[0] <= 1.2 * few[0] < 400
    loops, _ = statements_and_entries(family, sizes[1], name, reroll)
    assert loops > 5 * many[0]


def test_the_choice_between_loops_and_straight_code() -> None:
    small, large = lowered("chain", 7), lowered("chain", 48)
    branching = lowered("tree", 5)
    for machine, unroll, is_rolled in (
        (branching, "auto", True),
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
