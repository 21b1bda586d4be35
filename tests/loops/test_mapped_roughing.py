"""A contour that G71, G72 or G73 roughs and G70 finishes: displaced once, read back by its own words."""

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke
from tests.support.mapped import FREE, mapped
from tests.support.refusals import refused
from tests.support.roughing_reference import Piece
from trueloop.domain.option import MapOptions
from trueloop.errors import Code
from trueloop.nc.field import Field, affine_field, function_field
from trueloop.nc.program.program import read_program

SHIFT = affine_field(np.eye(3), [0.03, 0.0, -0.02])
ONWARD = function_field(
    lambda p: np.column_stack([0.02 + 2e-5 * p[:, 2] ** 2, 0 * p[:, 0], 0.01 - 1e-4 * p[:, 2]]), "onward"
)
"""Larger in X the further Z is from the face, as the contour is: it never turns back by it."""

TURNING = """\
O0001
G21 G18 G40 G99
T0101
G97 S800 M03
G00 X60. Z2.
{first}
{cycle} P10 Q20 U0.4 W0.1 F0.25
N10 G00 X20.{start}
G01 Z-10. F0.1
X26. Z-15.
Z-25.
G02 X36. Z-30. R5.
G01 X50.
N20 Z-45.
G00 X150. Z80.
T0202
G00 X60. Z2.
G70 P10 Q20
G00 X150. Z80.
M30
"""
CYCLES = {"G71": "G71 U2. R0.5", "G73": "G73 U4. W2. R3"}


def program(cycle: str, *, names_both: bool = False) -> str:
    return TURNING.format(cycle=cycle, first=CYCLES[cycle], start=" Z2." if names_both else "")


def contour(text: str) -> list[Piece]:
    """From block N10 to block N20, by their words alone: X a diameter, R a radius of less than half a turn."""
    lines = text.splitlines()
    first, last = (next(k for k, line in enumerate(lines) if line.startswith(n)) for n in ("N10", "N20"))
    before = re.findall(r"^G00 X([\d.]+) Z([-\d.]+)", "\n".join(lines[:first]), re.MULTILINE)[-1]
    at, code, pieces = (float(before[0]) / 2, float(before[1])), "G00", []
    for line in lines[first : last + 1]:
        words = dict(re.findall(r"([A-Z])\s*(-?[\d.]+)", line))
        code = f"G{int(words['G']):02d}" if "G" in words else code
        end = (float(words["X"]) / 2 if "X" in words else at[0], float(words["Z"]) if "Z" in words else at[1])
        centre = centre_of(at, end, float(words["R"]), code) if code in ("G02", "G03") else None
        if code != "G00":
            pieces.append(Piece(at, end, centre))
        at = end
    return pieces


def centre_of(start: tuple[float, float], end: tuple[float, float], radius: float, code: str) -> tuple[float, float]:
    """Clockwise with z to the right and x up has the centre on the right of the chord."""
    (x0, z0), (x1, z1) = start, end
    dx, dz = x1 - x0, z1 - z0
    chord = float(np.hypot(dx, dz))
    height = np.sqrt(radius**2 - chord**2 / 4) * (1 if code == "G02" else -1)
    return (x0 + x1) / 2 - height * dz / chord, (z0 + z1) / 2 + height * dx / chord


def points(pieces: list[Piece]) -> np.ndarray:
    return np.array([piece.at(share) for piece in pieces for share in np.linspace(0, 1, 301)])


def wanted(pieces: list[Piece], field: Field) -> np.ndarray:
    at = points(pieces)
    moved = field.displacement_mm(np.column_stack([at[:, 0], np.zeros(len(at)), at[:, 1]]))
    return at + moved[:, [0, 2]]


def below_mm(places: np.ndarray, piece: Piece) -> np.ndarray:
    """How far places (x, z) lie below a piece, nearer to the axis, where they lie beside it."""
    x, z = np.array([piece.at(share) for share in np.linspace(0, 1, 20001)]).T
    beside = places[(places[:, 1] > z.min() + 1e-6) & (places[:, 1] < z.max() - 1e-6)]
    order = np.argsort(z)
    below: np.ndarray = np.interp(beside[:, 1], z[order], x[order]) - beside[:, 0]
    return below


def off_mm(found: list[Piece], aim: np.ndarray) -> float:
    """The largest distance of the aim's points from the polyline that the found pieces make."""
    at = points(found)
    start, way = at[:-1], np.diff(at, axis=0)
    length2 = np.maximum((way**2).sum(axis=1), 1e-30)
    share = np.clip(((aim[:, None] - start) * way).sum(axis=2) / length2, 0, 1)
    return float(np.linalg.norm(start + share[:, :, None] * way - aim[:, None], axis=2).min(axis=1).max())


@pytest.mark.parametrize("dialect", ["fanuc-lathe", "haas-lathe"])
@pytest.mark.parametrize("cycle", CYCLES)
@pytest.mark.parametrize("field", [SHIFT, ONWARD], ids=["shift", "onward"])
def test_the_contour_is_displaced_once(cycle: str, dialect: str, field: Field, tmp_path: Path) -> None:
    text = program(cycle)
    written, done = mapped(tmp_path, text, field, dialect)
    aim = wanted(contour(text), field)
    assert off_mm(contour(written), aim) < 0.0005 + 0.0015 and not done.turns_back_line
    assert off_mm(contour(text), aim) > 0.015  # so that the wrong sign, or twice the displacement, would be seen
    line = next(line for line in written.splitlines() if line.startswith(f"{cycle} P10"))
    assert line == f"{cycle} P10 Q20 U0.4 W0.1 F0.25"
    assert re.search(r"^N10 G00 X20\.\d+$", written, re.MULTILINE), "the first block still names X alone"


@pytest.mark.parametrize("field", [SHIFT, ONWARD], ids=["shift", "onward"])
def test_no_roughing_pass_comes_nearer_to_the_displaced_contour(field: Field, tmp_path: Path) -> None:
    """Where the runner takes G71 of the written program apart, no move ends below contour and allowance."""
    written, _ = mapped(tmp_path, program("G71"), field, "fanuc-lathe")
    path = read_program(written.encode("latin-1"), "fanuc-lathe").run()
    cycle = written[: written.index("G71 P10")].count("\n") + 1
    own = np.flatnonzero(path.line == cycle)
    assert len(own) > 20
    ends = path.end_mm[own[1:-1]][:, [0, 2]]
    rough = [piece.moved((0.2, 0.1)) for piece in contour(written)]
    depths = [depth for piece in rough for depth in below_mm(ends, piece)]
    assert len(depths) > 10 and -1e-5 < max(depths) < 1e-5


def test_a_last_block_of_several_pieces_keeps_its_number_at_the_last(tmp_path: Path) -> None:
    """G70 runs to N20: what follows that number would be left out of the cut, and run on its own."""
    bent = function_field(lambda p: np.column_stack([1e-4 * p[:, 2] ** 2, 0 * p[:, 0], 0 * p[:, 0]]), "bent")
    text = program("G71")
    written, done = mapped(tmp_path, text, bent, "fanuc-lathe")
    lines = written.splitlines()
    assert done.added_blocks > 4 and sum(line.startswith("N20") for line in lines) == 1
    last = next(k for k, line in enumerate(lines) if line.startswith("N20"))
    assert "Z-45." in lines[last] and lines[last + 1].startswith("G00 X15")
    assert off_mm(contour(written), wanted(contour(text), bent)) < 0.002


def test_a_cut_that_would_start_beside_its_place_is_refused(tmp_path: Path) -> None:
    """X20 alone leaves Z where the cycle began; a chamfer from there needs the Z of its own beginning."""
    tilted = function_field(lambda p: np.column_stack([0 * p[:, 0], 0 * p[:, 0], 2e-3 * p[:, 0]]), "tilted")
    text = program("G71").replace("G01 Z-10. F0.1\nX26. Z-15.", "G01 X26. Z-3. F0.1\nZ-15.")
    refusal = refused(mapped, tmp_path, text, tilted, "fanuc-lathe")
    assert (refusal.code, refusal.place.line) == (Code.NC_MAP, 9) and "first block" in refusal.hint
    both = text.replace("N10 G00 X20.", "N10 G00 X20. Z2.")
    written, _ = mapped(tmp_path, both, tilted, "fanuc-lathe")
    assert off_mm(contour(written), wanted(contour(both), tilted)) < 0.002


def test_a_contour_that_is_roughed_alone_is_displaced_with_it(tmp_path: Path) -> None:
    text = program("G71").replace("G70 P10 Q20\n", "")
    written, done = mapped(tmp_path, text, ONWARD, "fanuc-lathe")
    assert off_mm(contour(written), wanted(contour(text), ONWARD)) < 0.002 and not done.not_run
    assert contour(written)[0].end[1] != contour(text)[0].end[1]


def test_a_contour_that_is_not_run_is_refused(tmp_path: Path) -> None:
    skipped = program("G71").replace("G70 P10 Q20", "/G70 P10 Q20")
    refusal = refused(mapped, tmp_path, skipped, SHIFT, "fanuc-lathe")
    assert (refusal.code, refusal.place.line) == (Code.NC_FLOW, 7) and "not run" in refusal.message
    mapped(tmp_path, skipped, SHIFT, "fanuc-lathe", MapOptions(skipped_blocks=True))


def test_a_displaced_contour_that_turns_back_is_told(tmp_path: Path) -> None:
    """A barrel of 20 µm on the cylinder of 10 mm: G71 of type I refuses such a contour."""
    barrel = function_field(lambda p: np.column_stack([0.02 * np.sin(p[:, 2]), 0 * p[:, 0], 0 * p[:, 0]]), "barrel")
    _, done = mapped(tmp_path, program("G71"), barrel, "fanuc-lathe")
    assert done.turns_back_line == 9
    source, table = tmp_path / "told.nc", tmp_path / "barrel.csv"
    source.write_text(program("G71"))
    rows = [f"{z},{20 * np.sin(z)}" for z in np.arange(-100.0, 100.0, 0.5)]
    table.write_text("\n".join(["z_mm,dx_um", *rows]))
    command = ["nc", "map", source, "-o", tmp_path / "out.nc", "--table", table, "-d", "fanuc-lathe"]
    told = invoke(*command, status=0).stderr
    assert f"{source}:9: warning NC-MAP: the displaced contour turns back" in told


def test_facing_shares_its_contour_too(tmp_path: Path) -> None:
    text = (
        "O0002\nG21 G18 G40 G99\nG00 X60. Z2.\nG72 W2. R0.5\nG72 P10 Q20 U0.4 W0.1 F0.25\nN10 G00 Z-20.\n"
        "G01 X40. F0.1\nX30. Z-10.\nX20.\nN20 Z2.\nG70 P10 Q20\nG00 X150. Z80.\nM30\n"
    )
    written, _ = mapped(tmp_path, text, ONWARD, "fanuc-lathe", FREE)
    in_air = 30  # X of the beginning is left as it is
    assert off_mm(contour(written), wanted(contour(text), ONWARD)[in_air:]) < 0.002
    assert re.search(r"^N10 G00 Z-[\d.]+$", written, re.MULTILINE)


def test_the_reader_of_words_reads_the_contour() -> None:
    pieces = contour(program("G71"))
    assert [piece.end for piece in pieces] == [(10, -10), (13, -15), (13, -25), (18, -30), (25, -30), (25, -45)]
    assert all(a.end == b.start for a, b in pairwise(pieces))
    assert pieces[3].centre is not None and np.allclose(pieces[3].centre, (18, -25))


STATED = """O1
G21 G99 G40
T0101
G97 S500 M3
G0 X42. Z5.
G76 P021060 Q100 R0.05
G76 X36.4 Z-25. P1840 Q400 F3.
G0 X42. Z2.
G90 X38. Z-30. F0.2
X36.
X34. Z-20. R-0.5
U-2.
G0 X50. Z-10.
G92 X40. W-10. F2.
X39.5
G0 X50. Z-30.
G75 R0.5
G75 X30. Z-40. P2000 Q2000 F0.1
G75 X0. P2000 F0.1
G0 X100. Z100.
M30
"""
STATED_SHIFTED = {
    5: "G0 X42.060 Z4.980",
    7: "G76 X36.460 Z-25.020 P1840 Q400 F3.",
    8: "G0 X42.060 Z1.980",
    9: "G90 X38.060 Z-30.020 F0.2",
    10: "X36.060",
    11: "X34.060 Z-20.020 R-0.5",
    13: "G0 X50.060 Z-10.020",
    14: "G92 X40.060 W-10. F2.",
    15: "X39.560",
    16: "G0 X50.060 Z-30.020",
    18: "G75 X30.060 Z-40.020 P2000 Q2000 F0.1",
    19: "G75 X0.060 P2000 F0.1",
    20: "G0 X100.060 Z99.980",
}


def test_a_turning_cycle_follows_the_end_that_it_states(tmp_path: Path) -> None:
    """SHIFT is 0.03 mm on the radius: 0.06 mm of a diameter. Tapers, depths and increments stay."""
    written = mapped(tmp_path, STATED, SHIFT, "fanuc-lathe")[0].splitlines()
    lines = [STATED_SHIFTED.get(k + 1, line) for k, line in enumerate(STATED.splitlines())]
    assert [line for line in written if "corrected" not in line] == lines
    before, after = (
        read_program(text.encode(), "fanuc-lathe").run(strict=False) for text in (STATED, "\n".join(written))
    )
    assert np.array_equal(before.motion, after.motion)
    assert after.end_mm - before.end_mm == pytest.approx(np.tile([0.03, 0.0, -0.02], (len(before), 1)), abs=1e-9)


def test_a_turning_cycle_whose_moves_would_go_apart_is_refused(tmp_path: Path) -> None:
    error = refused(mapped, tmp_path, STATED, ONWARD, "fanuc-lathe")
    assert (error.code, error.place.line) == (Code.NC_MAP, 7)
    assert "displaced differently" in error.message


STOCK = """G18 G90 G95 G40 DIAMON G54 G710
T1 D1
G96 S200 M4
G0 X62 Z2
CYCLE95("SHAFT",2,0.1,0.3,,0.3,0.15,0.1,{kind},,,1)
G0 X100 Z100
M30
%_N_SHAFT_SPF
G1 X20 Z0
X30 Z-5
Z-30
G2 X40 Z-35 CR=5
G1 X60
M17
"""
LAP = """G50 S2000
G0 X62 Z2
{call}
G0 X100 Z100
M2
NLAP G81
G0 X20
G1 Z0 F0.1
X30 Z-5
Z-30
X60
G80
"""


@pytest.mark.parametrize(
    ("text", "dialect", "contour"),
    [
        *((STOCK.format(kind=kind), "siemens", ["X30.06", "X40.06", "X60.06"]) for kind in (1, 5, 9)),
        (LAP.format(call="G85 NLAP D4 F0.3 U0.4 W0.1"), "okuma-lathe", ["X30.06", "Z-30.02"]),
        (LAP.format(call="G85 NLAP D4 F0.3 U0.4 W0.1\nG87 NLAP"), "okuma-lathe", ["X30.06", "Z-30.02"]),
    ],
)
def test_a_contour_of_a_cycle_by_name_is_displaced_once(
    tmp_path: Path, text: str, dialect: str, contour: list[str]
) -> None:
    written = mapped(tmp_path, text, SHIFT, dialect, replace(FREE, unit="mm" if dialect == "okuma-lathe" else None))[0]
    assert all(written.count(word) >= 1 for word in contour), written
    call = [line for line in text.splitlines() if "CYCLE95" in line or "NLAP" in line]
    assert [line for line in written.splitlines() if "CYCLE95" in line or "NLAP" in line] == call
