"""Blocks made by a Dask cluster that runs already.

The workers of the cluster need Linkwright in their environment, and see the folders of the store
and of the generated modules by the same paths.
"""

import math
import queue
import time
import warnings
from contextlib import suppress
from typing import Any

from codegen.errors import InputError, LinkwrightError
from runtime.sweeps.block import BlockReport, Job, run_block
from runtime.sweeps.local_workers import pickled

_PATIENCE = 10.0  # safety: s in which a scheduler must answer
_WORKER_PATIENCE = 30.0  # measured: s without a report, after which workers are asked for
_MOST_TASKS = 2048  # safety: blocks that the scheduler has at a time, more than any cluster's cores
_MOST_ATTEMPTS = 100  # safety: times that a block is given to the cluster anew, after lost workers


def import_programs() -> None:
    """Import in a worker what its first block needs, while the sweep is planned."""
    from importlib import import_module

    for name in ("runtime.sweeps.block", "runtime.dynamics.connected_simulation", "zarr"):
        import_module(name)


def run_pickled(job: bytes, block: int) -> BlockReport:
    """A block of a job that travels as it does to local processes."""
    import pickle

    return run_block(pickle.loads(job), block)


class ClusterWorkers:
    """The workers of a scheduler at an address."""

    replaced = 0

    def __init__(self, address: str) -> None:
        try:
            import distributed
        except ImportError as error:
            raise InputError(
                "A cluster needs Dask, which is not installed. Run pip install "
                "'linkwright[sweep]', in the checkout pip install '.[sweep]'."
            ) from error
        client: Any = distributed.Client  # which has no types
        self.address = address
        self.client: Any = None
        try:
            self.client = client(address, timeout=_PATIENCE, set_as_default=False)
            self.first = [
                self.client.submit(import_programs, workers=[worker], pure=False)
                for worker in self.client.nthreads()
            ]
        except Exception as error:
            if self.client is not None:
                with suppress(Exception):
                    self.client.close(timeout=_PATIENCE)
            raise InputError(
                f"No Dask scheduler answers at {address} ({error}). Start one, dask scheduler, and "
                "give the address that it prints (--scheduler tcp://HOST:8786)."
            ) from error
        self.answers: queue.SimpleQueue[tuple[int, Any]] = queue.SimpleQueue()
        self.times: dict[int, int] = {}
        self.futures: dict[int, Any] = {}
        self.last_worker = time.monotonic()  # when the cluster had a worker last; inf: said already

    def take(self, job: Job) -> None:
        """Make blocks of this job from now on."""
        self.job, self.digest = pickled(job), job.digest[:12]

    @property
    def room(self) -> int:
        """Number of blocks that the scheduler takes now."""
        return _MOST_TASKS - len(self.futures)

    def submit(self, block: int) -> None:
        """Have a block made by a worker of the cluster."""
        attempt = self.times[block] = self.times.get(block, 0) + 1
        future: Any = self.client.submit(
            run_pickled, self.job, block, pure=False, retries=0,
            key=f"linkwright-{self.digest}-{block}-{attempt}-{id(self):x}",
        )  # fmt: skip
        self.futures[block] = future
        future.add_done_callback(lambda future: self.answers.put((block, future)))

    def next(self, timeout: float) -> BlockReport | None:
        """The next report; None where there is none within so many seconds.

        Raises
        ------
        LinkwrightError
            If a block cannot be made at all, or the scheduler is lost.
        """
        try:
            block, future = self.answers.get(timeout=timeout)
        except queue.Empty:
            self._require_scheduler()
            self._warn_without_workers()
            return None
        if future.status == "finished":
            report = future.result()
            del self.futures[block]
            assert isinstance(report, BlockReport)
            return report
        if future.status == "error":
            self._failed(block, future.exception())
            return None
        self._require_scheduler(lost=True)
        return None

    def _failed(self, block: int, error: BaseException) -> None:
        """Give a block whose workers were lost to others; the journal finds the run that did it."""
        from distributed import KilledWorker

        if isinstance(error, KilledWorker) and self.times[block] < _MOST_ATTEMPTS:
            self.replaced += 1
            self.submit(block)
            return
        text = (
            str(error) if isinstance(error, LinkwrightError) else f"{type(error).__name__}: {error}"
        )
        raise LinkwrightError(f"The cluster cannot make block {block}: {text}")

    def _require_scheduler(self, *, lost: bool = False) -> None:
        if lost or self.client.status not in {"running", "connecting"}:
            raise LinkwrightError(f"The Dask scheduler at {self.address} does not answer any more.")

    def _warn_without_workers(self) -> None:
        """Say once that a cluster has no workers: it waits for them without a word."""
        if time.monotonic() - self.last_worker < _WORKER_PATIENCE:
            return
        if self.client.nthreads():
            self.last_worker = time.monotonic()
            return
        self.last_worker = math.inf
        warnings.warn(
            f"The cluster at {self.address} has no workers; the sweep waits for them. Start some: "
            f"dask worker {self.address} --nthreads 1.",
            stacklevel=2,
        )

    def close(self) -> None:
        """Cancel what is not done, and leave the cluster as it is."""
        if self.client.status == "closed":
            return
        if self.client.status == "running":
            self.client.cancel([*self.first, *self.futures.values()])
        self.client.close(timeout=_PATIENCE)
