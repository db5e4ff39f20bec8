"""The search for cycles stops within the block, and goes on behind it as it was."""

import gc

import pytest

from codegen.garbage_collection import collection_paused


def test_collection_pauses_and_goes_on_after_an_error() -> None:
    """Off inside, on behind the block, also where it raises."""
    inside = []

    @collection_paused()
    def fails() -> None:
        inside.append(gc.isenabled())
        raise ValueError("inside")

    assert gc.isenabled()
    with pytest.raises(ValueError, match="inside"):
        fails()
    assert inside == [False]
    assert gc.isenabled()


def test_collection_that_was_off_stays_off() -> None:
    """A pause within a pause ends with the outer one."""

    @collection_paused()
    def inner() -> bool:
        return gc.isenabled()

    with collection_paused():
        assert not inner()
        assert not gc.isenabled()
    assert gc.isenabled()


def test_blocks_that_make_little_leave_garbage_to_be_found() -> None:
    """Else a loop over such blocks would keep all of it: nothing there counts the old objects."""

    class Node:
        found = 0

        def __init__(self) -> None:
            self.me = self

        def __del__(self) -> None:
            Node.found += 1

    usual = gc.get_threshold()
    gc.set_threshold(700, 10, 10)
    try:
        for _ in range(2000):
            Node()
            with collection_paused():
                pass
    finally:
        gc.set_threshold(*usual)
    assert Node.found > 1000
