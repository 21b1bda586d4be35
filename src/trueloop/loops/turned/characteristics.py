"""The characteristics of a correction: in or out as measured, and as expected of the next cut."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic
from trueloop.domain.judged import Judged
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.composed import Surface, model_covariance
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.part_on_machine import InMachine
from trueloop.loops.turned.shifts import Shifts
from trueloop.turned.characteristics.covariance import Covariance, Places, of_measured_part, of_next_cut
from trueloop.turned.characteristics.judging import judged
from trueloop.turned.characteristics.measurand import measurand
from trueloop.turned.compensation.decide import Decision
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel

TOUCHED_MM: Final = 0.05
"""A place this close to a touch is the touched one."""


@dataclass(frozen=True)
class Corrected:
    """What one correction knows of the errors of the part that was touched and of the next one."""

    inputs: Inputs
    matched: Commanded
    surface: Surface
    model: ProfileErrorModel
    decision: Decision
    shifts: Shifts
    machine: InMachine | None

    def characteristics(self) -> tuple[Judged, ...]:
        """One for each that the inputs ask for, in their order. Raises TOL errors."""
        return tuple(self._judged(asked) for asked in self.inputs.characteristics)

    def _judged(self, asked: Characteristic) -> Judged:
        sizes = measurand(self.inputs.profile, asked, self._touches, self.inputs.part_zero_z_mm)
        places = Places(self.model, sizes.feature_index, sizes.arc_length_mm)
        after = judged(asked, sizes, self._expected_mm(places), self._next_cut(places))
        if not self.inputs.measured_finished:
            return Judged(asked, None, after)
        return Judged(asked, judged(asked, sizes, *self._measured(places)), after)

    @property
    def _touches(self) -> NDArray[np.intp]:
        """How many touches every feature has that count."""
        return np.bincount(self.model.vectors.feature_index[self.model.weight > 0.0], minlength=len(self.model.curves))

    def _expected_mm(self, places: Places) -> Array:
        """Errors that the next cut is expected to have: what is not taken out, and what of the program's stays."""
        curve, options, expected = places.curve_mm, self.inputs.options, places.expected_mm
        gain = places.each(lambda curve, s: np.full(len(s), curve.gain))
        by_offset = np.array(self.shifts.by_offset)[places.feature_index]
        offset = places.outward_normal @ np.array(self.decision.offset_mm)
        kept = places.shifted_mm(self.shifts.contour) - places.shifted_mm(self.shifts.correction)
        left = np.where(expected == curve, (1.0 - options.weight) * curve, expected - gain * options.weight * curve)
        return np.asarray(np.where(by_offset, expected + gain * offset, left) + kept)

    def _next_cut(self, places: Places) -> Covariance:
        covariance = of_next_cut(places, self.shifts.unasked)
        if self.machine is None:
            return covariance
        nominal, normal = places.nominal_mm, places.outward_normal
        return covariance.with_stated(model_covariance(self.machine, nominal, normal, self.inputs.nose_radius_mm))

    def _measured(self, places: Places) -> tuple[Array, Covariance]:
        """Errors of the part as it was touched: at touches their mean, else of process, program, machine."""
        error_mm = places.curve_mm + places.shifted_mm(self.matched.measured) + self._cut_in_mm(places)
        at, touch = self._touched(places)
        touches, here = self.surface.touches, np.unique(at)
        error_mm[here] = [np.mean(touches.error_mm[touch[at == k]]) for k in here]
        u_mm = np.array([np.max(touches.standard_u_mm[touch[at == k]]) for k in here])
        return error_mm, of_measured_part(places).with_measured(here, u_mm)

    def _touched(self, places: Places) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Places that were touched, and the touches there; those left out as bad say nothing."""
        touches = self.surface.touches
        same = np.equal.outer(places.feature_index, touches.feature_index) & (self.model.weight > 0.0)
        near = np.abs(np.subtract.outer(places.arc_length_mm, touches.arc_length_mm)) < TOUCHED_MM
        at, touch = np.nonzero(same & near)
        return at, touch

    def _cut_in_mm(self, places: Places) -> Array:
        """What the machine's errors put into the touched surface, straight from touch to touch of a feature."""
        touches, found = self.surface.touches, np.zeros(len(places.feature_index))
        for i in np.unique(places.feature_index):
            rows, touched = places.feature_index == i, touches.of_feature(i)
            if len(touched):
                at, cut_in = touches.arc_length_mm[touched], self.surface.cut_in_mm[touched]
                found[rows] = np.interp(places.arc_length_mm[rows], at, cut_in)
        return found
