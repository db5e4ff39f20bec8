"""The sequence of a kernel's operations: evaluated on demand, and its tandem repeats."""

import numpy as np

from codegen.lower.program import LEAVES, Kernel
from codegen.reroll.sequence import Stretch, order_on_demand, stretches
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


def cut(text: str) -> tuple[Stretch, ...]:
    codes = np.array([ord(c) for c in text], dtype=np.int64)
    return stretches(codes, np.zeros(len(codes) + 1, dtype=np.int64))


def covered(found: tuple[Stretch, ...], text: str) -> bool:
    """Whether the stretches follow each other, and each repeats itself."""
    place = 0
    for s in found:
        turns = [text[s.start + k * s.period :][: s.period] for k in range(s.turns)]
        if s.start != place or len(set(turns)) != 1:
            return False
        place = s.end
    return place == len(text)


def test_a_repeat_between_others() -> None:
    text = "xyz" + "abcdefg" * 5 + "uvw" + "hi" * 20
    found = cut(text)
    assert covered(found, text)
    assert [(s.period, s.turns) for s in found] == [(3, 1), (7, 5), (3, 1), (2, 20)]


def test_a_sequence_without_repetition_is_one_stretch() -> None:
    text = "".join(chr(97 + (k * k) % 53) for k in range(40))
    assert covered(cut(text), text)
    assert cut("abcdefghijklmnopqrst") == (Stretch(0, 20, 1),)
    assert cut("") == ()


def test_random_sequences_are_covered() -> None:
    random = np.random.default_rng(3)
    for _ in range(200):
        words = ["".join(random.choice(list("abc"), int(random.integers(1, 9)))) for _ in range(4)]
        text = "".join(word * int(random.integers(1, 12)) for word in words)
        assert covered(cut(text), text)


def test_a_repeat_begins_where_least_is_alive() -> None:
    text = "abcd" * 10
    alive = np.array([5 if k % 4 else 1 for k in range(len(text) + 1)], dtype=np.int64)
    alive = np.roll(alive, 2)
    codes = np.array([ord(c) for c in text], dtype=np.int64)
    found = stretches(codes, alive)
    (loop,) = [s for s in found if s.turns > 1]
    assert (loop.start - 2) % 4 == 0
