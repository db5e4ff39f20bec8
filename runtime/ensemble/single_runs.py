"""Members of an ensemble by single runs: the first, and those that the compiled loop leaves."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from codegen.errors import LinkwrightError
from runtime.core.outcomes import Outcome
from runtime.dynamics.simulation import simulate_joints
from runtime.ensemble.dataset import Rows
from runtime.ensemble.members import Members
from runtime.ensemble.preparation import Preparation, prepare
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.progress_bar import Progress, silent
from runtime.results.result import Result


@dataclass(frozen=True)
class SingleRuns:
    """What `simulate` takes for each member, and the rows that its results go into."""

    mechanism: Mechanism
    t_end: float
    members: Members
    rows: Rows
    options: Mapping[str, Any]

    def make(self, run: int, progress: Progress = silent) -> Result | None:
        """Make the run of a member; None where it is refused.

        Raises KeyboardInterrupt where the run was interrupted; its row is kept.
        """
        start = self.members.start_of(run) or None
        values = self.members.parameters_of(run) or None
        try:
            result = simulate_joints(
                self.mechanism, self.t_end, self.rows.times, parameters=values, start=start,
                progress=progress, **self.options,
            )  # fmt: skip
        except LinkwrightError as error:
            self.rows.refuse(run, error)
            return None
        self.rows.take(run, result)
        if result.outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        return result

    def prepare(self) -> tuple[int, Preparation | None]:
        """Make runs up to the first that ends well: the pattern of the others.

        Answers with the member that follows it, and with what all have in common.
        """
        for run in range(self.members.count):
            result = self.make(run)
            if result is not None and result.outcome is Outcome.OK:
                times = self.rows.times
                given = self.mechanism, self.t_end, times, self.members, run, result
                return run + 1, prepare(*given, self.options)
        return self.members.count, None
