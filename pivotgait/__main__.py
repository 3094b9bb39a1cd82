"""``python -m pivotgait``."""

from pivotgait.cli import main

main()
