"""Tandem repeats of sequences."""

import numpy as np

from codegen.reroll.sequence import Stretch, stretches


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
