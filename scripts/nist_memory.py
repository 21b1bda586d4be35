"""The ten worn-nose parts of [6811] as the memory of their edge sees them, in the order of their numbers."""

from functools import cache

import numpy as np

from scripts.nist_bands import PUBLISHED
from scripts.nist_parts import NistPart, parts
from trueloop.geometry.feature import contact_angle_rad
from trueloop.memory.made_part import ArcErrors, MadePart
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.touches.touches import Gauging, error_vectors

ARCS = ("dome", "knob")


@cache
def made_parts() -> tuple[MadePart, ...]:
    """All ten, MODBAS2 first."""
    return tuple(
        made_part(part, float(k))
        for k, part in enumerate(part for part in parts() if part.family.name in ("MODBAS2", "PIECS11"))
    )


def made_part(part: NistPart, order: float) -> MadePart:
    """The touches on the arc, and NIST's correction as [6811 §3.2] made it: a spline, positive where taken off."""
    touches = error_vectors(part.profile, part.semifinish, Gauging())
    published = touches.error_mm - fit_profile(part.profile, touches, PUBLISHED).residual_mm
    on_arc = np.array([part.profile.names[i] in ARCS for i in touches.feature_index])
    finish = np.array([touch.error_mm for touch in part.finish], dtype=np.float64)
    angle = contact_angle_rad(touches.outward_normal)
    names = tuple(part.profile.names[i] for i in touches.feature_index[on_arc])
    points = tuple(t.point for t, on in zip(part.semifinish, on_arc, strict=True) if on)
    u = touches.standard_u_mm[on_arc]
    return MadePart(
        part.family.name,
        part.number,
        "as reported",
        order,
        ArcErrors(names, points, angle[on_arc], touches.error_mm[on_arc], u),
        ArcErrors(names, points, angle[on_arc], finish[on_arc], u),
        published[on_arc],
    )
