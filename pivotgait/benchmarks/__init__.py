"""Timings against peers, as ratios measured in one run; building time of peers apart."""

from pivotgait.benchmarks.allocation import allocation_rows
from pivotgait.benchmarks.control import control_rows
from pivotgait.benchmarks.feasibility import feasibility_rows
from pivotgait.benchmarks.relocation import relocation_rows
from pivotgait.benchmarks.removal import removal_rows
from pivotgait.benchmarks.simulation import simulation_rows
from pivotgait.benchmarks.startup import import_rows
from pivotgait.benchmarks.sweeping import sweep_rows

__all__ = [
    "allocation_rows",
    "control_rows",
    "feasibility_rows",
    "import_rows",
    "relocation_rows",
    "removal_rows",
    "simulation_rows",
    "sweep_rows",
]
