"""Lift, removal and addition: each plans one phase of a gait."""
