"""COMP_MTG and COMP_PROC as one correction: P_commanded = P_nominal + COMP_MTG(T_cutting, P) + COMP_PROC(s).

COMP_MTG is taken where COMP_PROC sends the tool: P + COMP_PROC + COMP_MTG(P + COMP_PROC), so that what remains of a
known E is its change over the correction's own size.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.limits import Limits
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.deviations import SAMPLES
from trueloop.loops.turned.part_on_machine import InMachine
from trueloop.turned.compensation.contour import CentrePiece
from trueloop.turned.compensation.displaced import Displacement, magnitude
from trueloop.turned.compensation.limits import check_along, cut_mm
from trueloop.turned.compensation.shift import ZERO, Shift, sampled, weighted_sum
from trueloop.turned.touches.error_vectors import ErrorVectors


@dataclass(frozen=True)
class Surface:
    """What the machine did to touches and to the surface that was touched, along the normals, (n,), mm.

    `touches`: part errors as they are, E(T_probing) added to what the control reported. `reported_mm`: that without.
    `cut_in_mm`: E of the cut before, which the touched surface carries; it is no error of the process.
    """

    touches: ErrorVectors
    reported_mm: Array
    cut_in_mm: Array


def surface_of(
    machine: InMachine, reported: ErrorVectors, carried: bool, nose_radius_mm: float, allowance_mm: float
) -> Surface:
    """Touches of a part that stands in a machine, its errors taken out of them.

    COORDS_ACTUAL = COORDS_CONTROLLER − COMP_MTG(T_probing, COORDS_CONTROLLER), normal component, for touches taken on
    the machine. `carried`: the touched surface carries E of the cut before. What a reference point makes zero stays
    zero: its share is taken off all others.
    """
    part, normal = machine.part, reported.outward_normal
    surface_mm = reported.nominal_mm + allowance_mm * normal
    probed, cut_in = np.zeros(len(normal)), np.zeros(len(normal))
    if part.touched_on == "machine":
        ball_mm = surface_mm + part.ball_radius_mm * normal
        probed = _along(machine.probing.error_mm(ball_mm, -np.sign(np.round(normal, 9))), normal)
    if carried:
        cut_in = _along(machine.semifinishing.error_mm(surface_mm + nose_radius_mm * normal, machine.travel), normal)
    actual = replace(reported, error_mm=reported.error_mm + _from_reference(reported, probed))
    return Surface(actual, reported.error_mm, _from_reference(reported, cut_in))


def of_process(
    machine: InMachine, profile: Profile, in_force: Sequence[Shift], nose_radius_mm: float
) -> tuple[Shift, ...]:
    """What of a composed correction in force is the process's: the contour that ran less COMP_MTG at the temperatures
    of that cut.
    """
    kept = []
    for feature, shift in zip(profile.features, in_force, strict=True):
        s = np.linspace(0.0, feature.length_mm, SAMPLES)
        normal = feature.outward_normal(s)
        error_mm = machine.semifinishing.error_mm(feature.point_mm(s) + nose_radius_mm * normal, machine.travel)
        kept.append(weighted_sum(((1.0, shift), (1.0, sampled(s, _along(error_mm, normal))))))
    return tuple(kept)


def check_composed(
    pieces: Sequence[CentrePiece],
    corrections: Sequence[Shift],
    displacements: tuple[Displacement, Displacement],
    limits: Limits,
) -> None:
    """Refuses COMP_MTG, or its sum with COMP_PROC, where it is too large or too steep: CMP-SIZE, CMP-SLOPE.

    `displacements` of the corrected path: COMP_MTG alone, and with it what of COMP_PROC is no shift of a feature.
    """
    alone, whole = displacements
    for piece in pieces:
        check_along(piece, *magnitude(piece.shifted, ZERO, alone, cut_mm(piece)), limits, "COMP_MTG")
    for piece, own in zip(pieces, corrections, strict=True):
        check_along(piece, *magnitude(piece.shifted, own, whole, cut_mm(piece)), limits, "the composed correction")


def comp_mtg_at(machine: InMachine, touches: ErrorVectors, process_mm: Array, nose_radius_mm: float) -> Array:
    """COMP_MTG along the normal where the nose cuts the touched places, moved by COMP_PROC (n,) already, (n,)."""
    normal = touches.outward_normal
    at_mm = touches.nominal_mm + (nose_radius_mm + process_mm)[:, None] * normal
    return _along(machine.comp_mtg.displacement_mm(at_mm), normal)


def model_u_mm(machine: InMachine, touches: ErrorVectors, nose_radius_mm: float) -> Array:
    """Standard uncertainty of the next cut's error from that of the model's coefficients, (n,)."""
    covariance = model_covariance(machine, touches.nominal_mm, touches.outward_normal, nose_radius_mm)
    return np.asarray(np.sqrt(np.maximum(np.diag(covariance), 0.0)))


def model_covariance(machine: InMachine, nominal_mm: Array, normal: Array, nose_radius_mm: float) -> Array:
    """Covariance of the next cut's errors at places (n, 2) from that of the model's coefficients, (n, n).

    With δ(T) = E true − E modelled, the finished part keeps δ(cutting) − δ(semifinish), + δ(probing) of touches taken
    on the machine: equal temperatures leave one δ of three.
    """
    at_mm = nominal_mm + nose_radius_mm * normal
    rows = machine.finishing.sensitivities(at_mm, machine.travel, normal)
    rows = rows - machine.semifinishing.sensitivities(at_mm, machine.travel, normal)
    if machine.part.touched_on == "machine":
        ball_mm = nominal_mm + machine.part.ball_radius_mm * normal
        rows = rows + machine.probing.sensitivities(ball_mm, -np.sign(np.round(normal, 9)), normal)
    return np.asarray(rows @ machine.part.model.covariance @ rows.T)


def _along(vectors: Array, normal: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", vectors, normal))


def _from_reference(touches: ErrorVectors, along_mm: Array) -> Array:
    """The same with the part's z taken from the reference point, where there is one [6811 §5.1]."""
    reference = np.flatnonzero(touches.at_reference)
    if not len(reference):
        return along_mm
    k, facing = reference[0], touches.outward_normal[:, 1]
    return np.asarray(along_mm - facing / facing[k] * along_mm[k])
