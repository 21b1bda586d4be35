"""A refined model as values for JSON and for the page."""

import math
from typing import Literal

from trueloop.machine.model.model import Version
from trueloop.machine.refine.judged import LeftOut
from trueloop.machine.refine.left import Change
from trueloop.machine.refine.refine import Refined
from trueloop.report.diagnosis.machine_shapes import ChangeShape, LeftOutShape, RefinementShape
from trueloop.report.diagnosis.values import um
from trueloop.units import UM_PER_MM, URAD_PER_RAD


def refinement_shape(refined: Refined, version: Version) -> RefinementShape:
    """Makes the shape of a refined model with the version that it was given."""
    judged, by = refined.judged, version.accepted
    left = [_left_out("parts", judged.by_part)]
    if judged.by_type is not None:
        left.append(_left_out("part types", judged.by_type))
    return RefinementShape(
        version=version.number,
        parent=version.parent_sha256,
        reason=refined.reason,
        errors=list(version.errors),
        parts=refined.parts,
        left_out=left,
        better=judged.better,
        changes=[_change(one) for one in refined.changes],
        accepted=None if by is None else f"{by.who} {by.at}",
    )


def _left_out(of: Literal["parts", "part types"], one: LeftOut) -> LeftOutShape:
    return LeftOutShape(
        of=of,
        groups=one.groups,
        points=one.points,
        before_um=um(one.rms_old_mm),
        after_um=um(one.rms_new_mm),
        better_um=um(one.better_mm),
        standard_u_um=um(one.u_better_mm),
    )


def _change(one: Change) -> ChangeShape:
    scale = URAD_PER_RAD if one.error.is_rotation else UM_PER_MM
    old, new, u = (round(value * scale, 4) + 0.0 for value in (one.old, one.new, one.u))
    return ChangeShape(
        error=str(one.error),
        unit=one.error.unit,
        at=one.at if math.isfinite(one.at) else None,
        signals=dict(one.signals),
        old=old,
        new=new,
        standard_u=u,
    )
