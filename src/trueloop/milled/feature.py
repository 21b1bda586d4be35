"""Features of a milled part with walls along z, and how sizes and coordinates follow the errors of their surfaces.

The frame is the part's, mm. An error e is along the outward normal, positive where material was left on, as everywhere.
A surface point displaced by e moves its coordinate along the axis a by e·n_a, so that the coordinate of a whole feature
is the least-squares value Σ e·n_a / Σ n_a² over points spread evenly; a bore (n towards its axis) becomes narrower by
2·mean(e), a boss wider by as much.
"""

import math
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Vector

Kind: TypeAlias = Literal["bore", "boss", "slot", "rib", "face"]
Side: TypeAlias = Literal["", "climb", "conventional"]

ROUND: Final = ("bore", "boss")
PAIRS: Final = ("slot", "rib")
INSIDE: Final = ("bore", "slot")
AROUND: Final = 16
"""Points of a circle: enough for its mean, its centre and what differs over its depth."""
ALONG: Final = 1.0 - 1e-9
"""Cosine from which a direction is a feature's own normal."""


@dataclass(frozen=True)
class MilledFeature:
    """One feature, and what cuts it.

    `place_mm`: the centre of a bore, boss, slot or rib at its top; a point of a face. `size_mm`: the diameter, or the
    width between two parallel walls; 0 of a face. `direction`: the unit vector from the centre of a slot or rib to one
    wall, or the outward normal of a face; unused of a bore or boss. `depth_mm`: from the top down, positive; 0 of a
    face. `side`: how the finishing pass runs along the wall, empty: not known. `radius_at_control`:
    whether the tool's register of radii moves what it cuts here; `length_at_control`: 1 where that of lengths does, −1
    where the program subtracts the length (G44), 0 where no length is in force.
    """

    name: str
    kind: Kind
    place_mm: Vector
    tool: int
    work_offset: str
    size_mm: float = 0.0
    direction: Vector = (0.0, 0.0, 1.0)
    depth_mm: float = 0.0
    side: Side = ""
    radius_at_control: bool = True
    length_at_control: int = 1

    @property
    def inward(self) -> bool:
        """Returns whether its outward normals point towards its middle: a bore, a slot."""
        return self.kind in INSIDE

    def surface(self, below_top_mm: float | None = None) -> tuple[Array, Array]:
        """Returns points (n, 3), mm, and outward normals (n, 3) at a depth below the top, half of the feature's own
        where none is given: a circle, the middles of two walls, or the point of a face.
        """
        centre = np.array(self.place_mm)
        if self.kind == "face":
            return centre[None, :], np.array([self.direction])
        centre = centre - [0.0, 0.0, 0.5 * self.depth_mm if below_top_mm is None else below_top_mm]
        if self.kind in ROUND:
            angle = np.arange(AROUND) * (2.0 * math.pi / AROUND)
            outwards = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(AROUND)])
        else:
            outwards = np.array([self.direction, [-value for value in self.direction]])
        return centre + 0.5 * self.size_mm * outwards, -outwards if self.inward else outwards

    def size_weights(self, quantity: Quantity) -> Array | None:
        """Returns how the deviation of a diameter, radius or width follows errors at `surface`, (n,); None: no size."""
        sign = -1.0 if self.inward else 1.0
        if self.kind in ROUND and quantity in (Quantity.DIAMETER, Quantity.RADIUS):
            return np.full(AROUND, sign * (2.0 if quantity is Quantity.DIAMETER else 1.0) / AROUND)
        if self.kind in PAIRS and quantity is Quantity.LENGTH:
            return np.full(2, sign)
        return None

    def coordinate_weights(self, vector: Array) -> Array | None:
        """Returns how its displacement, as a scalar product with a vector (3,), follows the errors at `surface`, (n,);
        None where the feature does not show that: a bore along its axis, walls and faces along their plane.
        """
        normals, length = self.surface()[1], float(np.linalg.norm(vector))
        along = normals @ (vector / length)
        level = math.hypot(vector[0], vector[1]) >= ALONG * length
        shown = level if self.kind in ROUND else bool(np.all(np.abs(along) >= ALONG))
        return np.asarray(length * along / np.sum(along**2)) if shown else None
