"""The virtual machine tool: commanded paths in, the surface that results out."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trueloop._core import NoseSweep
from trueloop.arrays import Array
from trueloop.geometry.feature import contact_angle_rad
from trueloop.simulator.nose import Nose
from trueloop.simulator.path import SAME, CentrePath, Transfer
from trueloop.simulator.process import Backlash, Deflection, Repeatability, Stock, sweep

PER_MM: Final = 0.01
REFERENCE_C: Final = 20.0


@dataclass(frozen=True)
class ErrorTerm:
    """One term; `axis` 0 is x, 1 is z."""

    axis: int
    coefficient_mm: float
    x_power: int = 0
    z_power: int = 0
    temperature_power: int = 0


@dataclass(frozen=True)
class MachineError:
    """All terms. Without any the machine goes where it is commanded."""

    terms: tuple[ErrorTerm, ...] = ()

    def error_mm(self, position_mm: Array, temperature_c: float) -> Array:
        """Returns E at positions (n, 2), (n, 2)."""
        error = np.zeros_like(position_mm)
        x, z, warmer = position_mm[:, 0] * PER_MM, position_mm[:, 1] * PER_MM, temperature_c - REFERENCE_C
        for term in self.terms:
            shape = x**term.x_power * z**term.z_power * warmer**term.temperature_power
            error[:, term.axis] += term.coefficient_mm * shape
        return error


@dataclass(frozen=True)
class VirtualMachine:
    """One machine with one tool. Everything that makes its parts wrong is known.

    `tool_offset_mm` (x as a radius, z) is by how much the tool was set wrongly; `transfer` what the finish cut does
    otherwise than the cuts before it. `body_mm`: centres (x, z) from the nose centre of further circles of its radius
    that cut along with it, unworn: the rest of an insert that is more than a nose.
    """

    nose: Nose
    tool_offset_mm: tuple[float, float] = (0.0, 0.0)
    repeatability: Repeatability = field(default_factory=Repeatability)
    deflection: Deflection = field(default_factory=Deflection)
    backlash: Backlash = field(default_factory=Backlash)
    error: MachineError = field(default_factory=MachineError)
    transfer: Transfer = SAME
    body_mm: tuple[tuple[float, float], ...] = ()

    def cut(
        self,
        stock: Stock,
        paths: Sequence[CentrePath],
        rng: np.random.Generator,
        temperature_c: float = REFERENCE_C,
        transfer: Transfer = SAME,
    ) -> Stock:
        """Returns the stock after the nose was commanded along these paths: one cut of the process.

        The actual path is the commanded one with play, machine error, wrong setting, what gives way under the force,
        what this cut does otherwise (`transfer`), and what does not repeat; the surface is the envelope of the nose
        along it.
        """
        cut_mm = self.repeatability.draw_cut_mm(rng)
        actual = (
            self._actual(path, stock, cut_mm, rng, temperature_c) + transfer.displacement_mm(path) for path in paths
        )
        return stock.cut_by([one for at in actual for one in self._swept(at)])

    def _swept(self, at: Array) -> list[NoseSweep]:
        """What the insert passes over with its nose centre at these positions; the body first, the nose finishes."""
        unworn = Nose(self.nose.radius_mm)
        return [*(sweep(at + np.array(apart), unworn) for apart in self.body_mm), sweep(at, self.nose)]

    def _actual(
        self, path: CentrePath, stock: Stock, cut_mm: Array, rng: np.random.Generator, temperature_c: float
    ) -> Array:
        at = self.backlash.follow(path.centre_mm)
        at += self.error.error_mm(at, temperature_c) + np.asarray(self.tool_offset_mm)
        if not self.deflection.rigid and stock.sweeps:
            below = self.nose.radius_mm + self.nose.wear_at_mm(contact_angle_rad(path.normal))
            at += self.deflection.displacement_mm(path, at - below[:, None] * path.normal, stock)
        at += self.repeatability.displacement_mm(path, cut_mm, rng)
        return at
