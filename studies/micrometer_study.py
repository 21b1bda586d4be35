"""Six diameters by micrometer and nothing else: simulated shafts, corrected and held against their own ±U.

`python -m studies.micrometer_study --write` puts the table into docs/measurements.md; some minutes on two cores.

Every part of `examples/shaft` is cut by a virtual lathe of its own, whose errors are drawn from what workshops have and
not from the priors of the model under trial (`population`). A virtual hand reads six diameters after the semi-finish
cut; the loop corrects; the truth is the finished surface itself, at places all over the part.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.errors import TrueloopError
from trueloop.geometry.offset import nose_centre_path
from trueloop.jobs.turned.job import read_job
from trueloop.loops.batch import run_batch
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.outcome import expected_mm
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.turned.compensation.displaced import CentrePiece
from trueloop.turned.readings.matches import match_by_name
from trueloop.turned.readings.vectors import with_readings
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging
from trueloop.units import UM_PER_MM
from trueloop_lab.loops.turned import finish_along, finishing_machine, random_of
from trueloop_lab.simulator.machine import (
    Backlash,
    Deflection,
    ErrorTerm,
    MachineError,
    Repeatability,
    Stock,
    VirtualMachine,
    VirtualProbe,
)
from trueloop_lab.simulator.mill import VirtualCmm
from trueloop_lab.simulator.nose import CentrePath, Nose, Transfer, path_along, path_of_positions
from trueloop_lab.simulator.presets import Workshop

ROOT: Final = Path(__file__).parents[1]
PAGE: Final = ROOT / "docs" / "measurements.md"
BEGIN: Final = "<!-- written by studies/micrometer_study.py -->\n"
END: Final = "<!-- end of what is written -->\n"
JOB: Final = ROOT / "examples" / "shaft" / "job.toml"
ALLOWANCE_MM: Final = 0.2
PARTS: Final = 200
FIRST_SEED: Final = 910_000
PLACES: Final = 9
STEP_MM: Final = 0.02
ZERO_MM: Final = 0.001
"""Setting of the micrometer's zero: one error of all readings of a part, on the diameter, one standard deviation."""
READ_MM: Final = 0.0017
"""Feel and scale, another error of every reading: both together are the 2 µm that the readings state."""
EDGE_AT_DEG: Final = (0.0, 30.0, 60.0, 90.0)
NOSE_AT_DEG: Final = (-30.0, -15.0, 0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0, 105.0, 120.0, 135.0, 150.0)


@dataclass(frozen=True)
class Held:
    """Errors of one part at its places, µm: what was left, what was expected, and the ±U stated for it; (n,).

    `before_um` is what the uncorrected program would have left, as the semi-finish cut did. `feature_index` (n,).
    """

    feature_index: Array
    left_um: Array
    expected_um: Array
    expanded_u_um: Array
    before_um: Array
    by_offset: bool

    @property
    def inside(self) -> Array:
        """Whether the truth is within ±U of what was expected."""
        return np.asarray(np.abs(self.left_um - self.expected_um) <= self.expanded_u_um)


def population(seed: int) -> Workshop:
    """One lathe with one tool.

    Tool setting: touched off or measured on a presetter, within ±35 µm on x and z, any alike. Insert: nose radius
    within ±25 µm (moulded, and set at its tangent points, so that the error shows between them). Wear: a land of up to
    0.3 mm, the end of the edge's life (ISO 3685), at a clearance of 7°: up to 37 µm, deepest at a contact angle of 40°
    to 75°, where a finish cut touches. Taper: spindle axis and carriage within ±10 µm on the radius in 100 mm; cross
    slide square within 5 µm in 100 mm. Play of up to 8 µm on each axis. A steel part that springs away from its chuck.
    Every cut differs from the next by 2 µm as a whole and scatters along itself by 1.5 µm; what the edge does otherwise
    in the finish cut, by contact angle, is 2 µm (the causes are those of `turned/fit/between_cuts.py`).
    """
    rng = np.random.default_rng([seed, 7])
    setting_x, setting_z, radius = rng.uniform(-1.0, 1.0, 3) * (0.035, 0.035, 0.025)
    land, deepest = rng.uniform(0.0, 0.3), math.radians(rng.uniform(40.0, 75.0))
    taper, square = rng.uniform(-1.0, 1.0, 2) * (0.010, 0.005)
    play_x, play_z = rng.uniform(0.0, 0.008, 2)
    edge = 0.002 * rng.standard_normal(len(EDGE_AT_DEG))
    angle = np.radians(NOSE_AT_DEG)
    wear = -land * math.tan(math.radians(7.0)) * np.exp(-(((angle - deepest) / math.radians(25.0)) ** 2))
    between = np.sin(2.0 * np.clip(angle, 0.0, math.pi / 2)) ** 2
    form = wear - radius * (math.sqrt(2.0) - 1.0) * between
    machine = VirtualMachine(
        nose=Nose(0.8, tuple(angle.tolist()), tuple(form.tolist())),
        tool_offset_mm=(float(setting_x), float(setting_z)),
        repeatability=Repeatability(along_mm=0.0015, correlation_mm=2.0, cut_to_cut_mm=0.002),
        deflection=Deflection(1200.0, 2e-5, 1e-5, part_mm_per_n_mm3=4e-11, chuck_z_mm=-112.0, feed_mm_per_rev=0.12),
        backlash=Backlash(float(play_x), float(play_z)),
        transfer=Transfer(tuple(np.radians(EDGE_AT_DEG).tolist()), tuple(edge.tolist())),
        error=MachineError((ErrorTerm(0, float(taper), z_power=1), ErrorTerm(1, float(square), x_power=1))),
    )
    return Workshop(machine, VirtualProbe(1.5), VirtualCmm())


def made(inputs: Inputs, readings: Sequence[Reading], seed: int) -> Held | str:
    """One part: semi-finished, read, corrected, finished, and looked at everywhere; the refusal where it is refused."""
    workshop, rng = population(seed), random_of(seed, 0)
    machine, profile, nose_mm = workshop.machine, inputs.profile, inputs.nose_radius_mm
    rough, semifinish = (
        path_along(nose_centre_path(profile, nose_mm + left_mm).features)
        for left_mm in (2 * ALLOWANCE_MM, ALLOWANCE_MM)
    )
    semifinished = machine.cut(machine.cut(Stock(), [rough], rng), [semifinish], rng)
    touches = read_by_hand(inputs, readings, semifinished, rng)
    try:
        correction = compensate(replace(inputs, touches=touches))
    except TrueloopError as refusal:
        return str(refusal)
    path = path_of(correction.commanded if correction.decision.by_offset else correction.corrected)
    finished = finish_along(workshop, finishing_machine(workshop, correction), [path], semifinished, seed)
    return held(correction, semifinished, finished)


def path_of(pieces: Sequence[CentrePiece]) -> CentrePath:
    """The path of the nose centre, as positions: what the program, which is under G42, makes the control do."""
    positions = []
    for piece in pieces:
        count = max(2, round((piece.end_mm - piece.start_mm) / STEP_MM))
        positions.append(piece.shifted.centre_mm(np.linspace(piece.start_mm, piece.end_mm, count)))
    return path_of_positions(np.concatenate(positions))


def read_by_hand(inputs: Inputs, readings: Sequence[Reading], stock: Stock, rng: np.random.Generator) -> ErrorVectors:
    """The diameters of the part at the places of the readings, as a micrometer shows them."""
    profile, zero_mm = inputs.profile, ZERO_MM * rng.standard_normal()
    matched = [one for one in (match_by_name(profile, reading) for reading in readings) if one is not None]
    at = []
    for one in matched:
        feature = profile.features[one.feature_index]
        at.append((float(feature.start_mm[0]) + ALLOWANCE_MM, one.reading.place_mm[-1]))
    radius = np.array(at)[:, 0] + stock.height_mm(np.array(at), np.tile([1.0, 0.0], (len(at), 1)))
    diameter = 2.0 * radius + zero_mm + READ_MM * rng.standard_normal(len(at))
    shown = [
        replace(one, reading=replace(one.reading, actual=float(d))) for one, d in zip(matched, diameter, strict=True)
    ]
    return with_readings(profile, shown, None, Gauging(allowance_mm=ALLOWANCE_MM))[0]


def held(correction: Correction, semifinished: Stock, finished: Stock) -> Held:
    """The finished part at places along every feature, clear of its corners by a fortieth of its length."""
    rows = []
    for index, feature in enumerate(correction.profile.features):
        s = np.linspace(0.025, 0.975, PLACES) * feature.length_mm
        at, normal = feature.point_mm(s), feature.outward_normal(s)
        before = semifinished.height_mm(at + ALLOWANCE_MM * normal, normal)
        expected, u = expected_mm(correction, index, s), correction.next_cut(index, s).expanded_u_mm
        rows.append(np.column_stack([np.full(PLACES, index), finished.height_mm(at, normal), expected, u, before]))
    table = np.concatenate(rows)
    left_um, expected_um, u_um, before_um = UM_PER_MM * table[:, 1:].T
    return Held(table[:, 0], left_um, expected_um, u_um, before_um, correction.decision.by_offset)


def shaft() -> tuple[Inputs, tuple[Reading, ...]]:
    """The example's job, and the places at which it is read."""
    inputs = read_job(JOB).inputs
    readings = tuple(one for inspection in inputs.inspections for one in inspection.readings)
    assert all(one.quantity is Quantity.DIAMETER for one in readings)
    return replace(inputs, inspections=()), readings


def table(parts: Sequence[Held], inputs: Inputs) -> list[str]:
    """Rows of a Markdown table: a feature each, then measured, unmeasured, and all."""
    profile = inputs.profile
    read = sorted({int(i) for i in inputs.touches.feature_index})
    groups = [(feature.name, [k]) for k, feature in enumerate(profile.features)]
    others = [k for k in range(len(profile.features)) if k not in read]
    groups += [("features read", read), ("features not read", others), ("all", [*read, *others])]
    lines = ["| | Read | Before, RMS µm | After, RMS µm | ±U, RMS µm | Inside ±U |", "|---|--:|--:|--:|--:|--:|"]
    counts = [int(np.count_nonzero(inputs.touches.feature_index == k)) for k in range(len(profile.features))]
    for name, indices in groups:
        chosen = [np.isin(part.feature_index, indices) for part in parts]
        before, after, u = (
            math.sqrt(np.mean([np.mean(getattr(p, what)[c] ** 2) for p, c in zip(parts, chosen, strict=True)]))
            for what in ("before_um", "left_um", "expanded_u_um")
        )
        share = np.array([np.mean(p.inside[c]) for p, c in zip(parts, chosen, strict=True)])
        u_share = float(np.std(share, ddof=1) / math.sqrt(len(share)))
        lines.append(
            f"| {name} | {sum(counts[k] for k in indices)} | {before:.1f} | {after:.1f} | {u:.1f} | "
            f"{100 * np.mean(share):.1f} % ± {100 * u_share:.1f} |"
        )
    return lines


def main() -> None:
    """Prints the table, or writes it into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, default=PARTS)
    parser.add_argument("--seed", type=int, default=FIRST_SEED)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    inputs, readings = shaft()
    seeds = range(given.seed, given.seed + given.parts)
    every = list(run_batch(partial(made, inputs, readings), seeds, workers=2))
    parts = [part for part in every if isinstance(part, Held)]
    print(*(part for part in every if isinstance(part, str)), sep="\n", file=sys.stderr)
    lines = table(parts, inputs)
    offsets = sum(part.by_offset for part in parts)
    lines += ["", f"{len(parts)} of {given.parts} parts, the others refused; a tool offset was enough on {offsets}."]
    print("\n".join(lines))
    if given.write:
        text = PAGE.read_text(encoding="utf-8")
        before, rest = text.split(BEGIN)
        PAGE.write_text(before + BEGIN + "\n".join(lines) + "\n" + END + rest.split(END, 1)[1], encoding="utf-8")


if __name__ == "__main__":
    main()
