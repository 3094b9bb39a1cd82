"""Sweeps: many cells of a study over processes or a cluster, resumable after any kill.

To add a computation: give it a name in ``study_config.Compute`` with a time limit, write what
turns cells into outcomes (``static_grasps.py`` for cells solved together, ``whole_gaits.py`` one by
one), name its columns in ``evaluator.py`` and the cells of a part in ``parts.py``.
"""

from pivotgait.sweeps.cells import Cell, CellSpace
from pivotgait.sweeps.crews import crew
from pivotgait.sweeps.errors import StudyError, SweepError, SweepFolderError
from pivotgait.sweeps.estimate import Estimate, estimate
from pivotgait.sweeps.folder import SweepFolder, manifest_of, read_manifest
from pivotgait.sweeps.outcome import STATUSES, Outcome
from pivotgait.sweeps.part_files import PartSummary
from pivotgait.sweeps.results import read_results, read_timings
from pivotgait.sweeps.run import SweepSummary, run_sweep
from pivotgait.sweeps.study import Study, builtin_studies, export_study, load_study, parse_study
from pivotgait.sweeps.study_config import StudyConfig
from pivotgait.sweeps.study_results import StudyResults, study_results

__all__ = [
    "STATUSES",
    "Cell",
    "CellSpace",
    "Estimate",
    "Outcome",
    "PartSummary",
    "Study",
    "StudyConfig",
    "StudyError",
    "StudyResults",
    "SweepError",
    "SweepFolder",
    "SweepFolderError",
    "SweepSummary",
    "builtin_studies",
    "crew",
    "estimate",
    "export_study",
    "load_study",
    "manifest_of",
    "parse_study",
    "read_manifest",
    "read_results",
    "read_timings",
    "run_sweep",
    "study_results",
]
