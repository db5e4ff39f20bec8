"""Kernels in loops: what is written computes the program, and does not grow with the machine."""

import math

import numpy as np
import pytest

from codegen.emit.kernel import Arguments
from codegen.emit.module import kernel_texts
from codegen.emit.rolled_kernel import RolledKernelText
from codegen.lower.interpreter import evaluate
from codegen.reroll.batching import Batching, ExpressionTrees, list_schedule
from codegen.reroll.rerolling import Rerolling, with_affine_accesses
from codegen.reroll.sequence import OperationSequence, Stretch
from tests.codegen.reroll.machines import Rolling, lowered, rolled_text, run

CLOSE = 1e-12  # of the largest output: sums of a few hundred terms
LOOP = Stretch(100, 3, 40)
TURNS = np.arange(LOOP.turns)
PLACES = np.zeros(LOOP.turns, dtype=np.int64)  # all of one kind
ELSEWHERE = 10 * TURNS
ELSEWHERE[[0, -1]] = 999, -5


@pytest.mark.parametrize("least_mode", [0, 1])
@pytest.mark.parametrize("rolling", [Rerolling, Batching])
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
        statements_and_entries(family, size, name, Rerolling) for size in (16, 32, 64)
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
    few, many = (statements_and_entries(family, size, name, Batching) for size in sizes)
    assert many[0] <= 1.2 * few[0] < 400
    loops, _ = statements_and_entries(family, sizes[1], name, Rerolling)
    assert loops > 5 * many[0]


def test_the_choice_between_loops_and_straight_code() -> None:
    small, large = lowered("chain", 7), lowered("chain", 48)
    branching = lowered("tree", 7)  # beyond the length up to which straight code is faster
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


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ([(PLACES, 7 * TURNS), (PLACES, 500 - 2 * TURNS)], [LOOP]),  # straight lines
        ([], [LOOP]),
        # Every other turn reads at another distance, the first and the last elsewhere, or from
        # another kind of place; or the text without the table is longer.
        ([(PLACES, 10 * TURNS + 4 * (TURNS % 2))], [(100, 6, 20)]),
        ([(PLACES, ELSEWHERE)], [(100, 3, 1), (103, 3, 38), (217, 3, 1)]),
        ([(PLACES + (TURNS[-1] == TURNS), 10 * TURNS)], [(100, 3, 39), (217, 3, 1)]),
        ([(PLACES, np.random.default_rng(5).integers(0, 1000, LOOP.turns))], [LOOP]),
    ],
)
def test_a_loop_becomes_one_on_straight_lines_and_turns_beside_it(
    columns: list[tuple[np.ndarray, np.ndarray]], expected: list[tuple[int, int, int]]
) -> None:
    assert with_affine_accesses(LOOP, columns) == expected


@pytest.mark.parametrize("family", ["chain", "n_four_bar"])
def test_accelerations_of_a_row_read_one_table_that_of_the_checks(family: str) -> None:
    machine = lowered(family, 60)
    text = rolled_text(machine, machine.kernels["accelerations"], Rerolling)
    *others, checks = (table for table in text.tables if table.columns)
    assert len(checks.columns) == 3
    assert sum(len(table.columns) for table in others) <= 1


def trees_of(family: str, size: int) -> ExpressionTrees:
    machine = lowered(family, size)
    program, kernel = machine.program, machine.kernels["accelerations"]
    slots = Arguments.of(machine.description).slots(program)
    constants = {k: slots[k] for k in program.hoisted(kernel)}
    return ExpressionTrees(OperationSequence(program, kernel, constants), kernel)


def test_each_tree_is_in_one_batch_behind_all_that_it_takes() -> None:
    trees = trees_of("tree", 4)
    order = [tree for batch in list_schedule(trees) for tree in batch]
    place = {tree: k for k, tree in enumerate(order)}
    assert sorted(order) == list(range(len(trees.trees)))
    assert all(place[taken] < place[tree] for tree in order for taken in trees.takes(tree))


def test_the_trees_of_a_batch_are_of_one_kind() -> None:
    trees = trees_of("net", 4)
    batches = list_schedule(trees)
    assert all(len({trees.kinds[tree] for tree in batch}) == 1 for batch in batches)
    assert len(batches) < len(trees.trees) / 4


def test_each_operation_is_in_one_tree() -> None:
    trees = trees_of("tree", 4)
    places = [place for tree in trees.trees for place in tree.places]
    assert sorted(places) == list(range(len(trees.tree_of)))
    assert len(set(trees.kinds)) < 60
