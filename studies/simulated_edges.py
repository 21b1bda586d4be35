"""A part that several edges cut, on the virtual machine: each edge with a nose, a holder and errors of its own.

One stock, cut by one edge after the other in the job's order; one probe sees it all; one program corrects all edges.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Final, Literal

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Side
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.part import SetupCorrection, SetupCuts, correct_setup
from trueloop.nc.match.cutters import CuttingEdge
from trueloop.nc.match.own_contour import OwnContour
from trueloop.nc.program.called import CalledOffset
from trueloop.nc.program.program import Program
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop_lab.loops.turned import Trial, finishing_machine, probe_part, random_of, true_errors_mm
from trueloop_lab.simulator.machine import Repeatability, Stock
from trueloop_lab.simulator.nose import SAME, CentrePath, Nose, path_along
from trueloop_lab.simulator.presets import TOOL_MM_PER_N, WORN_AT_DEG, WORN_BY_UM, Workshop, workshop_of

GROOVE_NOSE_MM: Final = 0.2
GROOVE_WIDTH_MM: Final = 2.5
DISHED_MM: Final = 0.05
"""The front of a groove insert stands back between its corners, so that one corner alone leaves the floor."""
BODY_STEP_MM: Final = 0.13


def grooving(corner: Literal["left", "right"], repeatability: Repeatability | None = None) -> Workshop:
    """The same machine with a corner of a groove insert of 2.5 mm, corner radii 0.2 mm, for grooves in an outside.

    The corner is worn a tenth as much as NIST's insert, as long a nose as it allows; the right one is the left one's
    mirror image. The blade gives way by twice as much as an outside tool (all assumed). Its probe has a ball of 1 mm.
    """
    towards = 1.0 if corner == "left" else -1.0  # the body lies on this side of the corner, along z
    angles = tuple(math.radians(angle) for angle in WORN_AT_DEG)
    wear = tuple(0.1 * w / UM_PER_MM for w in WORN_BY_UM)
    if corner == "right":
        angles, wear = tuple(math.pi - angle for angle in reversed(angles)), tuple(reversed(wear))
    count = math.ceil((GROOVE_WIDTH_MM - 2.0 * GROOVE_NOSE_MM) / BODY_STEP_MM)
    body = tuple((DISHED_MM, towards * BODY_STEP_MM * (k + 1)) for k in range(count))
    made = workshop_of(Nose(GROOVE_NOSE_MM, angles, wear), 2.0 * TOOL_MM_PER_N, repeatability, SAME)
    return replace(made, machine=replace(made.machine, body_mm=body), probe=replace(made.probe, ball_radius_mm=0.5))


def with_nose(workshop: Workshop, radius_mm: float) -> Workshop:
    """Returns the workshop with a nose of another radius and the same wear."""
    nose = replace(workshop.machine.nose, radius_mm=radius_mm)
    return replace(workshop, machine=replace(workshop.machine, nose=nose))


@dataclass(frozen=True)
class EdgePaths:
    """Commanded paths of one edge's nose centre: before the finish cut, and in it."""

    edge: CuttingEdge
    rough: CentrePath
    semifinish: CentrePath
    finish: tuple[CentrePath, ...]


@dataclass(frozen=True)
class SeveralTrial:
    """A job of several edges ready to be simulated; `whole` says where to touch, and has no paths of its own."""

    whole: Trial
    cuts: tuple[tuple[OwnContour, Inputs], ...]
    edges: tuple[EdgePaths, ...]


@dataclass(frozen=True)
class SeveralPart:
    """One part that went through the loop; arrays of shape (n,) by gauging point, mm, positive = material left on.

    `expanded_u_mm` is the half width of the band that the correction of the point's edge promised.
    """

    joint: SetupCorrection
    touches: ErrorVectors
    finish_truth_mm: Array
    expanded_u_mm: Array


def several_trial(cuts: Sequence[tuple[OwnContour, Inputs]]) -> SeveralTrial:
    """Runs the job's program once; the cuts before it are along each edge's own contour, the allowance off."""
    edges = []
    for own, inputs in cuts:
        nose_mm, allowance_mm = own.edge.nose_radius_mm, inputs.allowance_mm
        rough, semifinish = (
            path_along(nose_centre_path(own.profile, nose_mm + left_mm).features, side=Side.AROUND)
            for left_mm in (2.0 * allowance_mm, allowance_mm)
        )
        edges.append(EdgePaths(own.edge, rough, semifinish, _paths(own, inputs, inputs.program)))
    return SeveralTrial(Trial(cuts[0][1], None, (), (), ()), tuple(cuts), tuple(edges))


def simulate_several(trial: SeveralTrial, workshops: Mapping[CalledOffset, Workshop], seed: int = 0) -> SeveralPart:
    """One part through the whole loop. Each edge cuts with its own workshop's machine; the first's probe touches."""
    rng, stock = random_of(seed, 0), Stock()
    for one in trial.edges:
        machine = workshops[one.edge.called].machine
        stock = machine.cut(stock, [one.rough], rng)
        stock = machine.cut(stock, [one.semifinish], rng)
    first = workshops[trial.edges[0].edge.called]
    touches = probe_part(trial.whole, first, stock, rng, first.temperatures_c[1])
    joint = correct_setup(SetupCuts(tuple((own, replace(inputs, touches=touches)) for own, inputs in trial.cuts)))
    truth = true_errors_mm(trial.whole, _finished(trial, workshops, joint, stock, seed))
    promised = {
        name: half_mm
        for one in joint.corrections
        for name, half_mm in zip(one.touches.point, one.prediction.expanded_u_mm, strict=True)
    }
    return SeveralPart(joint, touches, truth, np.array([promised[name] for name in touches.point]))


def _finished(
    trial: SeveralTrial, workshops: Mapping[CalledOffset, Workshop], joint: SetupCorrection, stock: Stock, seed: int
) -> Stock:
    rng = random_of(seed, 1)
    for (own, inputs), paths, made in zip(trial.cuts, trial.edges, joint.edges, strict=True):
        workshop = workshops[own.edge.called]
        machine, finish = workshop.machine, paths.finish
        if made.correction is not None:
            machine = finishing_machine(workshop, made.correction)
        if joint.program is not None:
            finish = _paths(own, inputs, inputs.program.rewritten(joint.program))
        stock = machine.cut(stock, finish, rng, workshop.temperatures_c[2], machine.transfer)
    return stock


def _paths(own: OwnContour, inputs: Inputs, program: Program) -> tuple[CentrePath, ...]:
    """The chains of feed moves of one edge, each with its normals out of the material."""
    run = Run(inputs.parameters, inputs.execute_deleted_blocks, called=own.edge.called)
    moves = run.moves(program, run.of(program))
    chains = [[move.path for move in chain] for _, chain in groupby(moves, key=lambda move: move.chain)]
    along = np.subtract(own.profile.features[-1].end_mm, own.profile.features[0].start_mm)
    return tuple(_as_the_profile(path_along(chain, side=Side.AROUND), along) for chain in chains)


def _as_the_profile(path: CentrePath, along_mm: Array) -> CentrePath:
    """A path that runs against the profile has the material on its left."""
    with_it = float((path.centre_mm[-1] - path.centre_mm[0]) @ along_mm) >= 0.0
    return path if with_it else replace(path, normal=-path.normal)
