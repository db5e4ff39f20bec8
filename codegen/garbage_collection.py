"""The search for cycles of garbage, which stops while a large structure is built."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collection_paused() -> Iterator[None]:
    """Within the block, or the decorated function, Python looks for no cycles among its objects.

    Values that live as long as the program are walked through again and again while more are
    built: a quarter of the time of lowering a row of four-bars with 400 loops. What lies in no
    cycle is freed as ever.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
