"""The table by program line takes the given program where the corrected program goes, by LinuxCNC's interpreter.

Both programs are interpreted by LinuxCNC; the table is looked up by brute force, row by row, by the lines that the
interpreter reports. Under G41 and G42 LinuxCNC itself keeps the nose off the contour, in both.
"""

import itertools
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from tests.support import erring_lathe
from tests.support.correction import EXAMPLES, NOW
from tests.support.line_table import added_mm, moves_of, off_moves_mm, off_places_mm, sent_to
from tests.support.linuxcnc import Move, Tool
from trueloop.arrays import Array
from trueloop.domain.part import PartType
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.jobs.turned.job import read_job
from trueloop.loops.realtime.process_table import PlacedCorrection, ProcessTable, process_table
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.part_on_machine import PartOnMachine
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.program import read_program
from trueloop.turned.options import Options
from trueloop.turned.touches.error_vectors import ErrorVectors

ORIGIN = (70.0, -120.0)
NM = 1e-6
UM = 1e-3
FINE = Options(chord_tolerance_mm=2e-5, by="contour")
"""The corrected program keeps to what was intended by 20 nm, the table by less."""
DECIMALS = 8
"""The corrected program is written so finely that its rounding is not what is judged."""

PIN = checked_profile(
    [
        Line("cylinder", (20.0, -60.0), (20.0, -25.0)),
        Line("shoulder", (20.0, -25.0), (15.0, -25.0)),
        Line("neck", (15.0, -25.0), (15.0, -10.0)),
        Arc("dome", (15.0, -10.0), (5.0, 0.0), (5.0, -10.0), np.pi / 2),
        Line("face", (5.0, 0.0), (0.0, 0.0)),
    ]
)
KNOB = checked_profile(
    [
        *PIN.features[:3],
        Arc("dome", (15.0, -10.0), (8.0, -3.0), (5.0, -13.0), float(np.arccos(60 / 109))),
        Line("face", (8.0, -3.0), (0.0, -3.0)),
    ]
)
"""Without tangent features: a correction's kink there may be a corner that LinuxCNC's G41 refuses."""


@dataclass(frozen=True)
class Judged:
    """A correction, its table, and what LinuxCNC makes of the given and of the corrected program."""

    correction: Correction
    table: ProcessTable
    given: list[Move]
    corrected: list[Move]

    def largest_off_mm(self) -> float:
        """How far the given program with the table and the corrected program lie apart anywhere, both ways round."""
        sent = sent_to(self.given, ORIGIN, 0.1)
        added, off = added_mm(self.table.blocks, sent)
        went = sent.at_mm + added
        assert np.all(np.isfinite(off[~sent.rapid])), "no line that cuts is without rows"
        assert np.max(off[np.isfinite(off)]) < 1.1 * UM, "rows lie on the path"
        fed = sent_to([move for move in self.corrected if move.kind != "rapid"], ORIGIN, 0.1).at_mm
        return float(max(np.max(off_moves_mm(went, self.corrected, ORIGIN)), np.max(off_places_mm(fed, went))))


def judged(inputs: Inputs, folder: Path, tip: int = 0, origin_mm: tuple[float, float] = ORIGIN) -> Judged:
    program = inputs.program
    fine = read_program(program.source, program.dialect.name, program.file, program.unit, DECIMALS)
    inputs = replace(inputs, program=fine, made_at=NOW)
    correction = compensate(inputs)
    table = process_table(inputs.program, inputs.run, correction, PlacedCorrection(origin_mm, tip))
    tools = [Tool(1, inputs.nose_radius_mm, tip or 9)]
    sources = correction.source_program, correction.corrected_program
    given, corrected = (moves_of(source, folder, tools) for source in sources)
    return Judged(correction, table, given, corrected)


START = "G21 G18 G8 G40 G90 G94 G91.1 G64 P0.002 Q0 F100\nT1 M6\n"
END = "G0 Z5\nG0 X30 Z5\nM2\n"


def turned_program(profile: Profile, nose_radius_mm: float, *, scale: float = 1.0) -> bytes:
    """The nose centre's path from chuck end to free end, in mm; X times `scale`, 2 for diameters."""
    path = nose_centre_path(profile, nose_radius_mm).features
    (x, z) = path[0].start_mm
    lines = [f"G0 X{scale * 30} Z-65", f"G1 X{scale * x:.6f} Z{z:.6f}"]
    for f in path:
        (x0, z0), (x, z) = f.start_mm, f.end_mm
        end = f"X{scale * x:.6f} Z{z:.6f}"
        arc = f"G2 {end} I{f.centre_mm[0] - x0:.6f} K{f.centre_mm[1] - z0:.6f}" if isinstance(f, Arc) else ""
        lines.append(arc or f"G1 {end}")
    mode = "G7" if scale == 2.0 else "G8"
    return (START.replace("G8", mode) + "\n".join([*lines, END.replace("30", f"{scale * 30}")])).encode()


def touches_on(profile: Profile, error_mm: Array | None = None) -> ErrorVectors:
    """Nine touches a feature. Their errors by a worn nose, of its contact angle alone; or those given."""
    index = np.repeat(np.arange(len(profile.features)), 9)
    s = np.concatenate([feature.length_mm * np.linspace(0.05, 0.95, 9) for feature in profile.features])
    pairs = list(zip(index.tolist(), s, strict=True))
    nominal = np.array([profile.features[i].point_mm(at) for i, at in pairs])
    normal = np.array([profile.features[i].outward_normal(at) for i, at in pairs])
    worn = 0.010 + 0.020 * normal[:, 0] - 0.012 * normal[:, 1] ** 2 + 0.05 * (normal[:, 0] * normal[:, 1]) ** 2
    names, flags = tuple(map(str, range(len(s)))), np.zeros(len(s), dtype=bool)
    error = worn if error_mm is None else error_mm
    return ErrorVectors(names, index, s, error, np.full(len(s), 5e-4), flags, nominal, normal)


def inputs_of(source: bytes, profile: Profile = PIN, options: Options = FINE, error_mm: Array | None = None) -> Inputs:
    program = read_program(source, "linuxcnc")
    return Inputs(PartType("pin"), profile, 0.8, program, touches_on(profile, error_mm), options, NOW)


@pytest.mark.parametrize("job", ["linuxcnc/job.toml", "loop/modbas2.toml"])
def test_an_example_goes_where_its_corrected_program_goes(job: str, tmp_path: Path) -> None:
    """Inch, diameters, a work of 92 mm in radius: within 0.1 µm of each other everywhere, ways in and out included."""
    inputs = read_job(EXAMPLES / job).inputs
    found = judged(replace(inputs, options=replace(inputs.options, chord_tolerance_mm=2e-5)), tmp_path)
    assert found.largest_off_mm() < 0.1 * UM
    assert np.max(np.abs(np.concatenate([block.rows[:, 2:] for block in found.table.blocks]))) > 50 * UM


@pytest.mark.parametrize("scale", [1.0, 2.0])
@pytest.mark.parametrize("follow", ["place", "nose"])
def test_a_worn_nose_on_an_arc(scale: float, follow: Literal["place", "nose"], tmp_path: Path) -> None:
    """X programmed as a radius and as a diameter: the rows are of the radius either way."""
    options = replace(FINE, errors_follow=follow)
    found = judged(inputs_of(turned_program(PIN, 0.8, scale=scale), options=options), tmp_path)
    assert found.largest_off_mm() < 0.1 * UM
    rows = next(block.rows for block in found.table.blocks if block.line == 8)
    assert len(rows) > 50 and np.ptp(rows[:, 2]) > 20 * UM and np.ptp(rows[:, 3]) > 5 * UM
    assert rows[0, :2] == pytest.approx([15.8 + 70.0, -10.0 - 120.0], abs=1e-6)


FORWARD = "G0 X20.8 Z-68\nG41 G1 X20 Z-63\nZ-25\nX15\nZ-10\nG2 X8 Z-3 I-10 K-3\nG1 X-2\nG40 G1 Z4\n"
BACKWARD = "G0 X30 Z5\nG42 G0 X-3 Z0\nG1 Z-3\nX8\nG3 X15 Z-10 I-3 K-10\nG1 Z-25\nX20\nZ-63\nG40 G1 X25\n"


@pytest.mark.parametrize("tip", [0, 3])
@pytest.mark.parametrize("contour", [FORWARD, BACKWARD], ids=["G41", "G42"])
def test_under_compensation_rows_are_where_the_control_drives(contour: str, tip: int, tmp_path: Path) -> None:
    """Edges that the nose is turned about, a corner that it does not get into; either way round."""
    along_z = contour.replace(
        "20.8", "21.6" if tip else "20.8"
    )  # by that the controlled point is off the nose's centre
    found = judged(inputs_of((START + along_z + END).encode(), KNOB), tmp_path, tip)
    assert found.largest_off_mm() < 0.1 * UM
    about_edge = next(block.rows for block in found.table.blocks if block.line == (6 if contour == FORWARD else 10))
    assert len(about_edge) > 10, "the arc about the edge is in the block after it"


def test_under_compensation_a_taper_goes_over_the_corner(tmp_path: Path) -> None:
    """Errors that grow along lines, which end where the nose does not get into the corner: 0.8 mm before it.

    On the way out by G40 the corrected program inherits its contour's X, the table holds what it added to the nose's
    centre: nose radius times slope apart, in the air.
    """
    touches = touches_on(KNOB)
    (x, z), (on_x, on_z) = touches.nominal_mm.T, touches.outward_normal.T
    error = 0.01 + 0.0008 * (z + 30.0) * on_x + 0.001 * x * on_z
    found = judged(inputs_of((START + FORWARD + END).encode(), KNOB, error_mm=error), tmp_path)
    *on_contour, way_out = [move for move in found.corrected if move.kind != "rapid"]
    sent = sent_to([move for move in found.given if move.line < 10], ORIGIN, 0.1)
    went = sent.at_mm + added_mm(found.table.blocks, sent)[0]
    assert np.max(off_moves_mm(went[~sent.rapid], on_contour, ORIGIN)) < 0.1 * UM
    assert np.max(off_places_mm(sent_to(on_contour, ORIGIN, 0.1).at_mm, went)) < 0.1 * UM
    assert np.linalg.norm(went[-1] - np.add(way_out.start_mm, way_out.origin_mm)[[0, 2]] - ORIGIN) < 0.1 * UM


def test_a_tool_offset_is_a_table_too(tmp_path: Path) -> None:
    """The corrected program shifts its frame by G52; the table adds the same along the contour."""
    inputs = inputs_of(turned_program(PIN, 0.8), options=replace(FINE, by="offset"))
    found = judged(inputs, tmp_path)
    assert found.correction.decision.by_offset and b"G52" in found.correction.corrected_program
    assert found.largest_off_mm() < 0.1 * UM
    assert any("is a tool offset" in note for note in found.table.notes)


def test_an_arc_about_an_edge_of_its_own_block(tmp_path: Path) -> None:
    """The program turns the nose about the shoulder's edge by itself: no feature, between two."""
    wide = checked_profile(
        [
            Line("cylinder", (26.0, -60.0), (26.0, -25.0)),
            Line("shoulder", (26.0, -25.0), (15.0, -25.0)),
            *PIN.features[2:],
        ]
    )
    source = turned_program(wide, 0.8).replace(
        b"G1 X26.800000 Z-24.200000\nG1 X15", b"G1 X26.8 Z-25\nG2 X26 Z-24.2 I-0.8 K0\nG1 X15"
    )
    assert b"I-0.8" in source
    found = judged(inputs_of(source, wide), tmp_path)
    assert found.largest_off_mm() < 0.1 * UM
    assert 6 in [block.line for block in found.table.blocks]


LEADS = [(0.020, "G0"), (-0.020, "G0"), (0.020, "G1")]


@pytest.mark.parametrize(("left_mm", "lead"), LEADS, ids=["towards", "away", "at feed"])
def test_a_rapid_onto_the_contour_comes_no_closer(left_mm: float, lead: str, tmp_path: Path) -> None:
    """Material left on is taken off: the rapid stays where it was. Towards the part goes the first cut alone."""
    source = turned_program(PIN, 0.8).replace(b"G1 X20.800000 Z-60", lead.encode() + b" X20.800000 Z-60")
    error = left_mm * touches_on(PIN).outward_normal[:, 0] ** 2
    found = judged(inputs_of(source, error_mm=error), tmp_path)
    sent = sent_to(found.given, ORIGIN, 0.05)
    added, _ = added_mm(found.table.blocks, sent)
    before_cut = sent.line < 5
    assert np.any(added[before_cut] != 0.0) == (lead == "G1" or left_mm < 0.0)
    assert np.max(np.abs(added[sent.line == 5])) == pytest.approx(0.020, abs=0.1 * UM)
    rapids = sent.rapid & before_cut
    assert np.all(added[rapids, 0] >= 0.0), "x, from which the part is approached"
    assert any("would come closer" in note for note in found.table.notes) == (lead == "G0" and left_mm > 0.0)


def test_what_is_added_goes_on_from_block_to_block(tmp_path: Path) -> None:
    """No step where one line ends and the next begins, from the way in to the way out, where nothing is added again."""
    found = judged(inputs_of(turned_program(PIN, 0.8)), tmp_path)
    blocks = found.table.blocks
    for before, after in itertools.pairwise(blocks):
        assert after.line == before.line + 1
        assert after.rows[0] == pytest.approx(before.rows[-1], abs=10 * NM)
    assert not np.any(blocks[0].rows[0, 2:]) and not np.any(blocks[-1].rows[-1, 2:])
    assert all(np.all(np.any(np.diff(block.rows[:, :2], axis=0) != 0.0, axis=1)) for block in blocks)


def test_between_rows_the_correction_is_linear(tmp_path: Path) -> None:
    """Rows and the line between them lie on the corrected path of the nose's centre, no program in between."""
    found = judged(inputs_of(turned_program(PIN, 0.8)), tmp_path)
    rows = next(block.rows for block in found.table.blocks if block.line == 8)
    share = np.linspace(0.0, 1.0, 9)[:, None]
    dense = np.concatenate([a + share * (b - a) for a, b in itertools.pairwise(rows)])
    dome = found.correction.corrected[3]
    circle = dense[:, :2] - np.array(ORIGIN) - np.array([5.0, -10.0])
    on_arc = circle * (10.8 / np.hypot(*circle.T))[:, None] + np.array([5.0, -10.0])  # where the command really is
    wanted = dome.shifted.centre_mm(np.linspace(dome.start_mm, dome.end_mm, 20001))
    assert np.max(off_places_mm((on_arc + dense[:, 2:])[::7], wanted)) < 10 * NM


ZERO, TOOL, CUTTING_C = (70.0, 0.0, -100.0), (-30.0, 0.0, 45.0), 28.0
STANDS = (ZERO[0] - TOOL[0], ZERO[2] - TOOL[2])


def on_erring_lathe() -> PartOnMachine:
    signals = {"T1": 22.0}
    return PartOnMachine(
        erring_lathe.model(), "0" * 64, ZERO, TOOL, TOOL, {"T1": CUTTING_C}, signals, signals, "cmm", "compensated"
    )


def in_real_time_mm(at_mm: Array, table_mm: Array) -> Array:
    """Where the drives are sent: the command, and c = table − E(command + c), asked twice, E by its formula."""
    added = table_mm
    for _ in range(2):
        there = at_mm + added
        added = table_mm - erring_lathe.error_mm(there[:, 0], there[:, 1], CUTTING_C)
    return np.asarray(at_mm + added)


def test_model_in_real_time_and_table_make_the_composed_program(tmp_path: Path) -> None:
    """COMP_MTG by the servo thread, COMP_PROC by the table: along the contour what one program carries of both.

    E is asked where the corrected command is here, before COMP_MTG there: 50 µm of 1 µm/mm, less than 0.1 µm.
    """
    inputs = replace(inputs_of(turned_program(PIN, 0.8)), machine=on_erring_lathe())
    found = judged(inputs, tmp_path, origin_mm=STANDS)
    sent = sent_to([move for move in found.given if 5 <= move.line <= 9], STANDS, 0.1)
    went = in_real_time_mm(sent.at_mm, added_mm(found.table.blocks, sent)[0])
    composed = [move for move in found.corrected if move.kind != "rapid"]
    assert np.max(off_moves_mm(went, composed, STANDS)) < 0.1 * UM
    assert np.max(off_places_mm(sent_to(composed[1:], STANDS, 0.1).at_mm, went)) < 0.1 * UM
    by_table_alone = sent.at_mm + added_mm(found.table.blocks, sent)[0]
    assert np.max(off_moves_mm(by_table_alone, composed, STANDS)) > 15 * UM, "COMP_MTG is not in the table"
    assert any("COMP_PROC alone" in note for note in found.table.notes)
