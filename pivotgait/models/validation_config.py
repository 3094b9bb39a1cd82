"""The perturbations of closed-loop trials in a scene file, as typed fields."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, FiniteFloat

from pivotgait.models.config import Config

Length = Annotated[FiniteFloat, Field(ge=0, le=0.05)]
Turn = Annotated[FiniteFloat, Field(ge=0, le=90)]
Share = Annotated[FiniteFloat, Field(ge=0, lt=1)]


class ValidationConfig(Config):
    """How far a trial may be from what its plan takes for granted.

    Every number is the half width of a uniform distribution about the plan's value, unless said
    otherwise.
    """

    laid_m: Length = 0.005
    """Where the tool lies, along world x and y; each trial is planned anew there."""
    laid_yaw_deg: Turn = 3.0
    """The yaw it lies at; each trial is planned anew for it."""
    pose_error_m: Length = 0.001
    """Error, along world x and y, of the pose that planner and controller take for true."""
    pose_error_deg: Turn = 1.0
    """Error of its yaw about the centre of mass."""
    mass_share: Share = 0.2
    """Of the tool's mass and inertia."""
    friction_share: Share = 0.2
    """Of the friction of fingertips, and independently of the table."""
    handle_width_m: Length = 0.001
    """Of the handle's width, which the shapes that form it share on both sides."""
    force_gain_share: Share = 0.25
    """Error of the gain of each fingertip's force reading."""
    force_direction_deg: Turn = 30.0
    """Largest angle between a fingertip's true force and its reading; from 0, any axis."""
    force_noise_N: Annotated[FiniteFloat, Field(ge=0, le=10)] = 0.05
    """Standard deviation of the white noise of each component of a force reading."""
    force_delay_s: Annotated[FiniteFloat, Field(ge=0, le=0.1)] = 0.002
    """Delay of the force readings; the same in every perturbed trial."""
    joint_friction_share: Share = 0.002
    """Largest dry friction of a joint, as a share of its effort limit; from 0."""
