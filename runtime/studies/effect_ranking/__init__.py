"""Which effects a question calls for: a scene judged by leaving each of them out in turn."""

from runtime.studies.effect_ranking.rank_effects import matters
from runtime.studies.effect_ranking.ranking import Costs, Matters, Proposal, Row, Verdict

__all__ = ["Costs", "Matters", "Proposal", "Row", "Verdict", "matters"]
