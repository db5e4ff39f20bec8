"""The order of evaluation on demand."""

from codegen.lower.program import LEAVES, Kernel
from codegen.reroll.sequence import order_on_demand
from tests.codegen.reroll.machines import lowered

LONG = 300  # operations, those of three bars


def kernel(name: str) -> tuple[tuple, Kernel]:
    machine = lowered("chain", 7)
    return machine.program.values, machine.kernels[name]


def test_the_order_has_each_value_once_behind_what_it_takes() -> None:
    values, accelerations = kernel("accelerations")
    order = order_on_demand(values, accelerations, ())
    place = {number: k for k, number in enumerate(order)}
    assert len(place) == len(order)
    assert {r for r in accelerations.roots if values[r].op not in LEAVES} <= set(place)
    for number, k in place.items():
        assert all(values[a].op in LEAVES or place[a] < k for a in values[number].args)


def test_what_stands_in_constants_is_not_computed_nor_what_only_it_takes() -> None:
    values, accelerations = kernel("accelerations")
    whole = order_on_demand(values, accelerations, ())
    cut = whole[len(whole) // 2]
    assert cut not in order_on_demand(values, accelerations, {cut})
    assert order_on_demand(values, accelerations, set(accelerations.roots)) == []


def test_the_terms_of_a_bar_stand_by_its_elimination() -> None:
    """Half as many values wait for long as in the order of derivation: those of substitution."""
    machine = lowered("chain", 48)
    values, accelerations = machine.program.values, machine.kernels["accelerations"]

    def waiting(order: list[int]) -> int:
        place = {number: k for k, number in enumerate(order)}
        uses = [(a, k) for number, k in place.items() for a in values[number].args if a in place]
        return sum(k - place[a] > LONG for a, k in uses)

    order = order_on_demand(values, accelerations, ())
    assert waiting(order) < 0.6 * waiting(sorted(order))
