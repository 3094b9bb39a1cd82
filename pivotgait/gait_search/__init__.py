"""From a tool and a wanted grasp to contacts and an order of gaits (search over grasps)."""

from pivotgait.gait_search.candidates import (
    Candidate,
    CandidateOptions,
    candidate_at,
    handle_candidates,
)
from pivotgait.gait_search.cost import Cost, CostWeights
from pivotgait.gait_search.deaths import Deaths
from pivotgait.gait_search.full_plan import FoundGait
from pivotgait.gait_search.goal_text import read_contacts, read_goal
from pivotgait.gait_search.goals import Goal, LiftedOff, NamedGrasp, PowerGrasp
from pivotgait.gait_search.search import search_gait
from pivotgait.gait_search.search_result import News, SearchOptions, SearchResult

__all__ = [
    "Candidate",
    "CandidateOptions",
    "Cost",
    "CostWeights",
    "Deaths",
    "FoundGait",
    "Goal",
    "LiftedOff",
    "NamedGrasp",
    "News",
    "PowerGrasp",
    "SearchOptions",
    "SearchResult",
    "candidate_at",
    "handle_candidates",
    "read_contacts",
    "read_goal",
    "search_gait",
]
