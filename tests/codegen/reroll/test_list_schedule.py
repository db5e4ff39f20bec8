"""The schedule of expression trees."""

from codegen.emit.argument_docstrings import Arguments
from codegen.reroll.batching import ExpressionTrees, list_schedule
from codegen.reroll.sequence import OperationSequence
from tests.codegen.reroll.machines import lowered


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
