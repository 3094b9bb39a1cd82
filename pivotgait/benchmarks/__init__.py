"""Timings against peers, as ratios measured in one run; building time of peers apart."""

from pivotgait.benchmarks.allocation import allocation_rows
from pivotgait.benchmarks.control import control_rows
from pivotgait.benchmarks.relocation import relocation_rows
from pivotgait.benchmarks.removal import removal_rows
from pivotgait.benchmarks.startup import import_rows

__all__ = ["allocation_rows", "control_rows", "import_rows", "relocation_rows", "removal_rows"]
