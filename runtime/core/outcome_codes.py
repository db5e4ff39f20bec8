"""Codes of the outcomes as plain numbers, for compiled code."""

from runtime.core.outcomes import Outcome

OK = int(Outcome.OK)
INCONSISTENT = int(Outcome.INCONSISTENT)
ZENO = int(Outcome.ZENO)
STEP_TOO_SMALL = int(Outcome.STEP_TOO_SMALL)
MAX_STEPS = int(Outcome.MAX_STEPS)
NEWTON_FAILED = int(Outcome.NEWTON_FAILED)
SINGULAR = int(Outcome.SINGULAR)
NOT_FINITE = int(Outcome.NOT_FINITE)
