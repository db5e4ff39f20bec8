"""The blocks of a sweep are handed to a pool until all are done, or the user stops it."""

import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import contextmanager, suppress
from typing import NamedTuple

from codegen.errors import InputError, LinkwrightError
from codegen.object_display import counted
from codegen.termination_signals import SignalDeferral
from runtime.progress_bar import bar
from runtime.sweeps.block import BlockReport, remove_parts
from runtime.sweeps.store import Store, open_store
from runtime.sweeps.workers import Pool

_MOST_ATTEMPTS = 100  # safety: times that a block is given to workers anew, after lost ones
_SIGNALS = 0.2  # layout: s between looks for a signal to stop


class Execution(NamedTuple):
    """How the making of the blocks went."""

    runs: int  # made in this session
    seconds: float  # of the wall clock
    simulation: float  # s of the processors in runs
    overhead: float  # s of the processors of workers in all else
    replaced: int  # workers that were lost


def execute(pool: Pool, store: Store, blocks: list[int], title: str, progress: bool) -> Execution:
    """Have a pool make these blocks of a store, and close it.

    Raises
    ------
    LinkwrightError
        If the workers cannot go on, or rows do not arrive in the store; what is done stays.
    """
    began, before = time.perf_counter(), store.blocks - len(blocks)
    with SignalDeferral(computing=True) as signals, _advice(store):
        try:
            with bar(title, progress) as report:
                reports, replaced = make_blocks(
                    pool, blocks, signals, lambda done: report((before + done) / store.blocks)
                )
        finally:
            with suppress(OSError):
                pool.close()
        missing = store.unfinished([one.block for one in reports])
        if missing:
            raise LinkwrightError(
                f"{counted(len(missing), 'block')} of {store.path} are not whole though they were "
                f"made, the first is {missing[0]}: another program has changed the store, or the "
                "disk fails."
            )
        signals.answered = len(reports) < len(blocks)
        if not signals.answered:
            remove_parts(store.path)
    return Execution(
        sum(one.runs for one in reports), time.perf_counter() - began,
        sum(one.simulation for one in reports), sum(one.overhead for one in reports), replaced,
    )  # fmt: skip


def make_blocks(
    pool: Pool, blocks: Sequence[int], signals: SignalDeferral, report: Callable[[int], None]
) -> tuple[list[BlockReport], int]:
    """The reports of the blocks until all are there or a signal arrives; the workers lost."""
    reports, waiting, losses = list[BlockReport](), deque(blocks), Counter[int]()
    running = dict[Future[BlockReport], int]()
    while len(reports) < len(blocks) and not signals.arrived:
        while waiting and len(running) < pool.room and not signals.arrived:
            try:
                block = waiting.popleft()
                running[pool.submit(block)] = block
            except KeyboardInterrupt:  # of a run in this process: the signal itself is noted
                return reports, losses.total()
        done, _ = wait(running, _SIGNALS, FIRST_COMPLETED)
        for future in done:
            block = running.pop(future)
            try:
                reports.append(future.result())
            except pool.lost as error:  # the journal finds the run that ended it
                losses[block] += 1
                if losses[block] > _MOST_ATTEMPTS:
                    raise LinkwrightError(f"Block {block} cannot be made: {error}") from error
                waiting.appendleft(block)
            except CancelledError:
                pool.check()
                raise
            report(len(reports))
        if not done:
            pool.check()
    return reports, losses.total()


@contextmanager
def _advice(store: Store) -> Iterator[None]:
    """Add to an error what is done, and how to go on."""
    try:
        yield
    except Exception as error:
        text = (
            f"{store.path} cannot be written: {error}."
            if isinstance(error, OSError)
            else (f"The blocks cannot be made: {type(error).__name__}: {error}")
        )
        problems = error.problems if isinstance(error, LinkwrightError) else (text,)
        try:
            done = store.blocks - len(open_store(store.path).unfinished())
        except InputError as damage:  # the store is no more
            raise LinkwrightError((*problems, *damage.problems)) from error
        kept = (
            f"{done} of {counted(store.blocks, 'block')} are done and kept in {store.path}. Go on "
            "with the same command and --resume (resume=True)."
        )
        raise LinkwrightError((*problems, kept)) from error
