"""What is shown of an edge."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.edge_life import EdgeLife
from trueloop.domain.life import Cut
from trueloop.errors import Finding
from trueloop.memory.edge.learnt import Learnt


@dataclass(frozen=True, eq=False)
class ShownEdge:
    """The life of an edge, the cuts of it, and what it has taught: None while no part of it was touched.

    `unseen_rad`: nothing is predicted at angles farther from all that were seen. `minutes_in_cut` None: not stated.
    """

    life: EdgeLife
    cuts: tuple[Cut, ...]
    learnt: Learnt | None
    findings: tuple[Finding, ...]
    minutes_in_cut: float | None
    unseen_rad: float


def angles_deg(found: Learnt) -> Array:
    """The angles of what was learnt, in degrees."""
    return np.degrees(found.contact_angle_rad)


def unseen(shown: ShownEdge, found: Learnt) -> Flags:
    """At which of them nothing was seen (n,)."""
    return found.nearest_rad > shown.unseen_rad
