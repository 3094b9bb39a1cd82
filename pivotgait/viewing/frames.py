"""A whole gait at even times: where every body is and which forces act."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.plans.plan import ContactTrack, GaitPlan
from pivotgait.plotting.posture import Skeleton, skeleton
from pivotgait.plotting.timeline import Span, spans

RATE_HZ = 30.0
"""Frames per second unless told otherwise."""


@dataclass(frozen=True, eq=False)
class BodyFrames(FrozenArrays):
    """Poses of one body at M frames.

    Attributes:
        position: (M, 3) origin in the world [m].
        wxyz: (M, 4) unit quaternions, world <- body, scalar first.
    """

    position: Array
    wxyz: Array


@dataclass(frozen=True, eq=False)
class ContactFrames(FrozenArrays):
    """One contact over the whole gait.

    Attributes:
        track: the contact as its first phase has it.
        point: (M, 3) in the world [m]; NaN while it does not exist.
        force: (M, 3) on the tool, in the world [N]; zero while it does not exist.
    """

    track: ContactTrack
    point: Array
    force: Array


@dataclass(frozen=True, eq=False)
class Frames:
    """A gait at M even times.

    Attributes:
        time: (M,) from the start of the gait [s].
        phase: (M,) number of the phase.
        tool: poses of the tool frame.
        links: by name of the link; empty without a robot.
        contacts: one entry for each contact and place that it has on the tool.
        spans: the phases and their times.
        skeleton: the arm-hand, None without one.
    """

    time: Array
    phase: NDArray[np.intp]
    tool: BodyFrames
    links: Mapping[str, BodyFrames]
    contacts: tuple[ContactFrames, ...]
    spans: tuple[Span, ...]
    skeleton: Skeleton | None

    def __len__(self) -> int:
        return len(self.time)

    def at(self, time: float) -> int:
        """Number of the frame nearest to ``time`` [s]."""
        return int(np.argmin(np.abs(self.time - time)))


def frames(plan: GaitPlan, rate: float = RATE_HZ) -> Frames:
    """Sample a gait ``rate`` times per second [Hz], its last moment included.

    Between two samples of the plan positions, joints and forces go straight, and the tool turns
    about a fixed axis.

    Raises:
        InputError: if ``rate`` is not a positive number, or a phase has no motion of the robot.
        UrdfError: if the robot's URDF is broken.
    """
    if not (np.isfinite(rate) and rate > 0.0):
        raise InputError(f"{rate} frames per second", where="view", mend="give a positive rate")
    timeline = spans(plan)
    total = timeline[-1].end
    time = np.linspace(0.0, total, max(2, int(np.ceil(total * rate)) + 1))
    starts = np.array([span.start for span in timeline])
    phase = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, len(timeline) - 1)
    chosen = [time[phase == number] for number in range(len(timeline))]
    tool = _joined([_tool(span, at) for span, at in zip(timeline, chosen, strict=True)])
    body = skeleton(plan.robot) if plan.robot else None
    return Frames(
        time,
        phase,
        tool,
        MappingProxyType(_links(body, timeline, chosen) if body else {}),
        _contacts(timeline, chosen, tool, phase),
        timeline,
        body,
    )


def _joined(parts: list[BodyFrames]) -> BodyFrames:
    return BodyFrames(
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.wxyz for part in parts]),
    )


def _between(span: Span, values: Array, at: Array) -> Array:
    """Columns of ``values`` (N, k) of a phase at times ``at`` (m,) of the gait."""
    columns = [np.interp(at, span.time, column) for column in values.T]
    return np.stack(columns, axis=-1)


def _tool(span: Span, at: Array) -> BodyFrames:
    motion = span.phase.tool
    turn = Slerp(span.time, motion.rotation)(np.clip(at, span.time[0], span.time[-1]))
    return BodyFrames(_between(span, motion.position, at), turn.as_quat(scalar_first=True))


def _links(
    body: Skeleton, timeline: tuple[Span, ...], chosen: list[Array]
) -> dict[str, BodyFrames]:
    parts = []
    for span, at in zip(timeline, chosen, strict=True):
        if span.phase.robot is None:
            raise InputError("has no motion of the robot", where=span.phase.name, mend="plan anew")
        parts.append(_between(span, span.phase.robot.q, at))
    poses = body.poses(np.concatenate(parts))
    return {
        name: BodyFrames(
            pose[:, :3, 3],
            Rotation.from_matrix(pose[:, :3, :3]).as_quat(scalar_first=True),
        )
        for name, pose in poses.items()
    }


def _contacts(
    timeline: tuple[Span, ...], chosen: list[Array], tool: BodyFrames, phase: NDArray[np.intp]
) -> tuple[ContactFrames, ...]:
    """One entry for each contact that lies elsewhere or has another normal or friction."""
    found: dict[tuple[object, ...], tuple[ContactTrack, Array]] = {}
    for number, (span, at) in enumerate(zip(timeline, chosen, strict=True)):
        for track in span.phase.contacts.values():
            place = np.round(np.concatenate((track.point, track.normal)), 9)
            key = (track.name, track.friction, *place.tolist())
            _, force = found.setdefault(key, (track, np.full((len(phase), 3), np.nan)))
            force[phase == number] = _between(span, track.force, at)
    turn = Rotation.from_quat(tool.wxyz, scalar_first=True).as_matrix()
    entries = []
    for track, force in found.values():
        there = np.isfinite(force[:, :1])
        point = track.point if track.is_pivot else tool.position + turn @ track.point
        entries.append(ContactFrames(track, np.where(there, point, np.nan), np.nan_to_num(force)))
    return tuple(entries)
