"""Changes of a whole part, known by an edge's memory or by one number."""

from collections.abc import Sequence

from trueloop.domain.life import Stage
from trueloop.memory.edge.innovation import innovations
from trueloop.memory.made_part import MadePart
from trueloop.memory.noticing.alarm import Noticed
from trueloop.memory.noticing.notice import notice


def notice_part(history: Sequence[MadePart], part: MadePart) -> dict[Stage, Noticed]:
    """Returns by cut how a part differs from the prediction of earlier parts of the edge, in cutting order.

    Its touches are judged by earlier parts, its finish inspection by these and by its own touches. A cut without places
    is absent, and so are all of a part before which none was inspected: what is believed beforehand is no reason to
    call a part changed.
    """
    parts = sum(earlier.uncorrected_mm is not None for earlier in history)
    if not parts:
        return {}
    found = {}
    for one in innovations(history, part):
        finish = part.finish if one.stage is Stage.FINISH else None
        found[one.stage] = notice(
            one.error_mm,
            one.covariance_mm2,
            one.contact_angle_rad,
            parts,
            None if finish is None else one.correction_mm,
            None if finish is None else part.from_memory_mm,
            (part.semifinish if finish is None else finish).point,
        )
    return found
