"""Small studies, and the command of a process that fails on purpose."""

from __future__ import annotations

import sys
from pathlib import Path

GRID = """\
schema: pivotgait-study/1
name: small
scene: knife
compute: static
axes:
  tool.pitch_deg: {values: [20, 40]}
  table.friction: {linspace: {from: 0.1, to: 0.9, count: 3}}
  contacts.*.friction: {range: {from: 0.2, to: 1.0, step: 0.2}}
"""
DRAWN = """\
schema: pivotgait-study/1
name: drawn
scene: knife
compute: static
axes:
  table.friction: {values: [0.3, 0.5]}
  contacts.*.friction: {normal: {mean: 0.8, sd: 0.1}}
  tool.mass_scale: {uniform: {from: 0.8, to: 1.2}}
  contacts.index_edge.along_m: {loguniform: {from: 0.03, to: 0.05}}
draws: 10
seed: 4
"""
TROUBLED = (sys.executable, str(Path(__file__).with_name("troubled_child.py")))
"""Command of a computing process that fails on some cells, see the file."""
