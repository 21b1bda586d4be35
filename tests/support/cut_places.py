"""Places of a cut of one part for tests of the estimator."""

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.estimate.places import Observed, Places

CYLINDER, FACE = np.pi / 2, 0.0


def places(
    contact_angle_rad: ArrayLike,
    z_mm: ArrayLike = 0.0,
    share: ArrayLike = 0.5,
    group: ArrayLike = 0,
    *,
    part: int = 1,
    finish: bool = False,
    edge: str = "edge",
    part_type: str = "type",
) -> Places:
    """n places; the number of the part is its order and the age of its edge."""
    angle, z, along, groups = np.broadcast_arrays(contact_angle_rad, z_mm, share, group)
    angle, z, along, groups = (np.atleast_1d(column) for column in (angle, z, along, groups))
    labels = {"tool": "tool", "edge": edge, "setting": "setting", "part_type": part_type, "part": part}
    numbers = {
        "age": float(part),
        "order": float(part),
        "finish": float(finish),
        "taken_off_mm": 0.0,
        "radius_mm": 20.0,
    }
    columns = {name: np.full(len(angle), value) for name, value in {**labels, **numbers}.items()}
    return Places({**columns, "contact_angle_rad": angle, "z_mm": z, "share": along, "group": groups})


def touches(at: Places, error_um: ArrayLike, u_um: float = 0.0) -> Observed:
    """Errors at places, in µm, with the standard uncertainty of the probe."""
    error: Array = np.asarray(error_um, dtype=np.float64)
    return Observed(at, 1e-3 * error, np.full(len(at), 1e-3 * u_um))
