"""Cells in a process of their own, so that a run that hangs can be ended and reported."""

import multiprocessing
from collections.abc import Callable
from multiprocessing.connection import Connection

from models.hard.suite.case import Case
from models.hard.suite.cell import Cell, Setting, prepare, run

LIMIT = 60.0
"""Seconds of wall time that a cell may take."""

START = 900.0
"""Seconds that may pass until a machine is built, compiled and ready."""

Find = Callable[[str], Case]


def serve(find: Find, pipe: Connection) -> None:
    """Answer (case, setting, rtol) with a cell, (case, setting, None) when the case is ready."""
    while (request := pipe.recv()) is not None:
        name, fields, rtol = request
        try:
            case = find(name)
            setting = Setting(*fields)
            pipe.send(prepare(case, setting) if rtol is None else run(case, setting, rtol))
        except Exception as error:
            pipe.send(f"{type(error).__name__}: {error}")


class Worker:
    """A process that runs cells; started anew where one hangs.

    Parameters
    ----------
    find
        A case's name → the case; a function that can be imported.
    limit
        Seconds that a cell may take.
    """

    def __init__(self, find: Find, limit: float = LIMIT) -> None:
        self.find, self.limit = find, limit
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=serve, args=(self.find, theirs), daemon=True)
        self.process.start()

    def run(self, case: Case, setting: Setting, rtol: float) -> Cell:
        """One cell.

        Raises
        ------
        RuntimeError
            Where the cell could not be run at all: its machine does not build, or the reference
            is not there.
        """
        if not self._answers(case, setting, None, START):
            raise RuntimeError(f"{case.name}, {setting.method}: not ready after {START:g} s")
        self._received(case)
        if not self._answers(case, setting, rtol, self.limit):
            return Cell.hanging(case.name, setting, rtol, self.limit)
        cell = self._received(case)
        assert isinstance(cell, Cell)
        return cell

    def _received(self, case: Case) -> Cell | None:
        """The answer; what went wrong over there is raised here."""
        answer = self.pipe.recv()
        if isinstance(answer, str):
            raise RuntimeError(f"{case.name}: {answer}")
        return answer

    def _answers(self, case: Case, setting: Setting, rtol: float | None, patience: float) -> bool:
        """Ask, and wait for an answer; without one the process is ended and another begun."""
        self.pipe.send((case.name, tuple(setting), rtol))
        if self.pipe.poll(patience):
            return True
        self.process.kill()
        self.process.join()
        self._start()
        return False

    def close(self) -> None:
        """End the process."""
        self.pipe.send(None)
        self.process.join()
