"""The numbers at a milling machine's control, the errors that they leave, and the parts that were cut with them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.estimate.places import Observed, Places
from trueloop.milled.observed import ObservedSize, shift_basis, turn_basis, wall_share

Register: TypeAlias = Literal["radius", "length", "x", "y", "z", "turn"]

PLAINEST: Final[tuple[Register, ...]] = ("radius", "length", "x", "y", "z", "turn")


@dataclass(frozen=True, order=True)
class Entry:
    """A number at the control: which register, and of which tool (its number) or work offset."""

    register: Register
    of: str

    @property
    def words(self) -> str:
        """Returns words such as `tool 2, radius` or `G54, X`."""
        if self.register in ("radius", "length"):
            return f"tool {self.of}, {self.register}"
        return f"{self.of}, {'rotation about Z' if self.register == 'turn' else self.register.upper()}"

    def basis(self, places: Places) -> Array:
        """Returns the error that an entry of +1 (mm, or rad of a turn) leaves at places, (N,)."""
        if self.register in ("radius", "length"):
            mine = np.asarray(places.columns["tool"]) == self.of
            moved = wall_share(places) if self.register == "radius" else places.number("normal_z")
            effect = moved * places.number(f"{self.register}_at_control")
        else:
            mine = np.asarray(places.columns["work_offset"]) == self.of
            turn = self.register == "turn"
            effect = turn_basis(places)[:, 0] if turn else shift_basis(places)[:, "xyz".index(self.register)]
        return np.where(mine, effect, 0.0)


Entered: TypeAlias = Mapping[Entry, float]
"""Totals since the first measured part, mm or rad."""


@dataclass(frozen=True, eq=False)
class Part:
    """One measured part in the order of cutting: what was seen with which deviations, and the entries in force."""

    serial: str
    shown: tuple[ObservedSize, ...]
    observed: Observed
    in_force: Entered

    def as_first_set(self) -> Observed:
        """Returns the values without what the entries in force did to them."""
        effect = sum((value * one.basis(self.observed.places) for one, value in self.in_force.items()), np.zeros(1))
        known = self.observed.of(np.broadcast_to(effect, len(self.observed.places)))
        return replace(self.observed, value_mm=self.observed.value_mm - known)
