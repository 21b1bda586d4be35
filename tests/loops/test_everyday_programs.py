"""Everyday finish programs are written as they stand: by another reader their path is off the profile by −e."""

import math
import sys
from pathlib import Path

import pytest

from tests.support.everyday import Everyday, Piece, driven, everyday, off_mm, places
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.process_intermittent import compensate

FAST = 24
LIMIT_MM = 1.3e-3
"""0.5 mm on either axis of a control with steps of 1 µm, both ends of a move, and 0.25 µm of chords."""


def error_um(at: tuple[float, float], normal: tuple[float, float], seed: int) -> float:
    """A tool that stands off by (x, z), and a taper along the seats."""
    dx, dz = 14.0 - seed % 29, 5.0 - seed % 11
    return normal[0] * (dx + 0.08 * (at[1] + 52.0)) + normal[1] * dz


def job_of(case: Everyday, seed: int, folder: Path) -> Path:
    ends = [case.start, *(piece.end for piece in case.pieces)]
    lines = ["[part]", 'name = "shaft"', f"start = {list(ends[-1])}"]
    for piece, end in zip(reversed(case.pieces), reversed(ends[:-1]), strict=True):
        lines += ["[[part.feature]]", f'name = "{piece.name}"', f"to = {list(end)}"]
        if piece.centre is not None:
            lines += [f"centre = {list(piece.centre)}", f'turn = "{"concave" if piece.name == "fillet" else "convex"}"']
    number = "number = 3" if "twice" in case.form else "number = 1"
    lines += ["[tool]", f"nose_radius_mm = {case.nose_radius_mm}", number]
    lines += ["[programs]", f'dialect = "{case.dialect}"', 'finish = "finish.nc"']
    lines += ["[gauging]", 'touches = "touches.csv"', "repeatability_diameter_um = 0.1", "repeatability_face_um = 0.1"]
    lines += ["[compensation]", 'by = "contour"', "[output]", 'folder = "out"', ""]
    rows = ["point,feature,nominal_x_mm,nominal_z_mm,error_um"]
    rows += [
        f"{k},{name},{at[0]:.7f},{at[1]:.7f},{error_um(at, normal, seed):.4f}"
        for k, (name, at, normal) in enumerate(reversed(places(case)), 1)
    ]
    (folder / "finish.nc").write_text(case.text)
    (folder / "touches.csv").write_text("\n".join([*rows, ""]))
    (folder / "job.toml").write_text("\n".join(lines))
    return folder / "job.toml"


def check(seed: int, folder: Path) -> None:
    """Compares the written program with −e; every pass of it, where the blocks of the contour run several times."""
    case = everyday(seed)
    given = [one for one in driven(case.text, case.dialect) if len(one) >= len(case.pieces)]
    assert all(abs(off_mm(one, at, normal)) < 1e-6 for one in given for _, at, normal in places(case)), case.form
    written = compensate(read_job(job_of(case, seed, folder)).inputs).corrected_program.decode()
    passes = [one for one in driven(written, case.dialect) if len(one) >= len(case.pieces)]
    assert len(passes) == len(given) > 0, case.form
    for one in passes:
        for name, at, normal in places(case):
            off = off_mm(one, at, normal) + error_um(at, normal, seed) / 1e3
            assert math.isfinite(off) and abs(off) <= LIMIT_MM, f"{case.form}: {name} {off * 1e3:.2f} µm\n{written}"


@pytest.mark.parametrize("seed", range(FAST))
def test_it_is_written_as_it_stands(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)


FILLET = """%
O1000
G20 G40 G80 G99
T0101
G96 S200 M3
G0 X0.6299 Z0.1575
G42 G1 X0.0000 Z0.0000 F0.0039
G1 X0.7874
G1 Z-1.1024
G2 X0.9449 Z-1.1811 I0.07874 K0.00000
G1 X1.1024
G1 X1.1811 Z-1.2205
G1 Z-1.9685
G40 G1 U0.2362
G0 X4.7244 Z2.3622
M30
%
"""
FILLET_PIECES = (
    Piece("front", (10.0, 0.0)),
    Piece("seat1", (10.0, -28.0)),
    Piece("fillet", (12.0, -30.0), (12.0, -28.0)),
    Piece("shoulder", (14.0, -30.0)),
    Piece("edge2", (15.0, -31.0)),
    Piece("seat2", (15.0, -50.0)),
)


def test_a_fillet_whose_end_is_rounded_off_its_arc_ends_on_the_wall(tmp_path: Path) -> None:
    """Coordinates to 0.0001 inch, the centre to 0.00001: the arc ends 1.5 µm off its circle. The wall reads 4 µm too
    low, and is written 4 µm higher: -30 mm + 4 µm are -1.18094 inch, from the end of the fillet on.
    """
    case = Everyday("haas-lathe", FILLET, (0.0, 0.0), FILLET_PIECES, 0.8, "inch")
    written = compensate(read_job(job_of(case, 53, tmp_path)).inputs).corrected_program.decode()
    *_, fillet = (line for line in written.splitlines() if line.startswith("G2 "))
    assert float(fillet.split(" Z")[1].split()[0]) == pytest.approx(-1.18094, abs=4e-5), written


if __name__ == "__main__":  # scripts/fuzz.sh: python -m tests.loops.test_everyday_programs COUNT SECONDS
    import tempfile
    from time import monotonic

    until = monotonic() + float(sys.argv[2])
    for k in range(int(sys.argv[1])):
        if monotonic() > until:
            print(f"{k} programs in {sys.argv[2]} s")
            break
        with tempfile.TemporaryDirectory() as scratch:
            check(k, Path(scratch))
