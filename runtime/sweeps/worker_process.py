"""A worker process on this computer: it takes numbers of blocks, and answers with their reports.

It ends as soon as the process that started it has ended, however that was.
"""

import contextlib
import os
import pickle
import queue
import signal
import threading
from typing import Any, BinaryIO

START = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from runtime.sweeps.worker_process import main
main()
"""
"""Program of the process; its argument is the path of modules of the process that starts it."""


def main() -> None:
    """Serve until the pipe to the starting process is closed."""
    for name in ("SIGINT", "SIGHUP"):  # those of the terminal are for the starting process
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    incoming, outgoing = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a function of the user's own prints is none of our answers
    orders: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(incoming, orders), daemon=True).start()
    try:
        from runtime.sweeps.block import run_block

        job = orders.get()
        _answer(outgoing, ("ready", None))
        while True:
            _answer(outgoing, _report(run_block, job, orders.get()))
    except BaseException as error:
        _answer(outgoing, ("error", f"{type(error).__name__}: {error}"))
        raise


def _report(run_block: Any, job: Any, block: int) -> tuple[str, Any]:
    from codegen.errors import LinkwrightError

    try:
        return "done", run_block(job, block)
    except LinkwrightError as error:
        return "error", str(error)
    except Exception as error:
        return "error", f"{type(error).__name__}: {error}"


def _answer(stream: BinaryIO, message: tuple[str, Any]) -> None:
    with contextlib.suppress(OSError):  # of a process that has ended
        pickle.dump(message, stream)
        stream.flush()


def _listen(stream: BinaryIO, orders: "queue.SimpleQueue[Any]") -> None:
    try:
        while True:
            orders.put(pickle.load(stream))
    except BaseException:
        os._exit(1)  # nobody is there for whom to finish a block
