"""Effect ranking: the influence of each effect of a scene on a quantity, and its cost."""

from runtime.studies.effect_ranking.rank_effects import matters
from runtime.studies.effect_ranking.ranking import Costs, Matters, Proposal, Row, Verdict

__all__ = ["Costs", "Matters", "Proposal", "Row", "Verdict", "matters"]
