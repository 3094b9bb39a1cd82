"""Whether finger contacts lie on the tool's surface, with the surface's normal; by Coal."""

from __future__ import annotations

from collections.abc import Iterator

import coal
import numpy as np

from pivotgait.certification.certificate import Finding
from pivotgait.certification.solid import RigidTool, Solid
from pivotgait.frozen import Array
from pivotgait.plans import ContactTrack, Phase

# The probe hovers this far outside the contact. Distances between separated convex shapes are exact
# to rounding, penetrations are not; and at an edge every normal of the edge's own cone passes.
_HOVER = 1e-4
_PROBE_RADIUS = 5e-5


def check_surface(rigid: RigidTool, phase: Phase) -> Iterator[Finding]:
    """Unit normals; distance of each finger contact from the surface, angle of its normal.

    A probe stands at ``point - HOVER * normal``. For a contact on the surface with the true inward
    normal its distance from the tool is HOVER and the nearest direction is that normal.
    """
    for name, contact in sorted(phase.contacts.items()):
        length = float(np.linalg.norm(contact.normal))
        yield Finding("normal_norm", abs(length - 1.0), phase.name, name)
        if contact.is_pivot or length == 0.0:
            continue
        distance, angle = _probe(rigid, contact, contact.normal / length)
        yield Finding("contact_surface_m", abs(distance - _HOVER), phase.name, name)
        yield Finding("contact_normal_rad", angle, phase.name, name)


def _probe(rigid: RigidTool, contact: ContactTrack, inward: Array) -> tuple[float, float]:
    """Distance [m] of the hovering probe's centre and angle [rad] of the nearest direction."""
    centre = contact.point - _HOVER * inward
    distance, direction = min(
        (_distance(solid, centre) for solid in rigid.solids), key=lambda found: found[0]
    )
    turned = float(np.linalg.norm(np.cross(direction, inward)))
    return distance, float(np.arctan2(turned, direction @ inward))


def _distance(solid: Solid, centre: Array) -> tuple[float, Array]:
    """Signed distance [m] of a point from a shape and unit direction from the point to it."""
    at_shape = coal.Transform3s(solid.rotation, solid.translation)
    at_probe = coal.Transform3s(np.eye(3), centre)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.gjk_tolerance = 1e-12
    probe = coal.Sphere(_PROBE_RADIUS)
    distance = coal.distance(probe, at_probe, solid.geometry, at_shape, request, result)
    return float(distance) + _PROBE_RADIUS, np.array(result.normal)
