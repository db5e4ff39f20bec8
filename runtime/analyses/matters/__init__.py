"""Which effects a question calls for: a scene judged by leaving each of them out in turn."""

from runtime.analyses.matters.answer import Costs, Matters, Proposal, Row, Verdict
from runtime.analyses.matters.judging import matters

__all__ = ["Costs", "Matters", "Proposal", "Row", "Verdict", "matters"]
