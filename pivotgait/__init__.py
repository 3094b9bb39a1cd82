"""Dynamic finger gaits on a pivoting hand tool: plan, certify, simulate and explain."""

__version__ = "0.1.0"
