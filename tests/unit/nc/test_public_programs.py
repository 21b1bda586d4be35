"""LinuxCNC's sample programs: its own interpreter makes the same moves of them."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.columns import assert_cleared, sampled
from tests.support.csv_reference import csv_lines
from tests.support.linuxcnc import LATHE_STARTUP, Tool, interpret
from tests.support.nc_judge import assert_same_moves
from tests.support.roughing_reference import Piece
from trueloop.errors import Code
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath, csv_text

pytestmark = pytest.mark.corpus


@pytest.mark.parametrize(
    ("name", "plane", "moves"), [("linuxcnc-lathe-pawn.ngc", 18, 146), ("linuxcnc-3d-chips.ngc", 17, 4684)]
)
def test_linuxcnc_makes_the_same_moves(corpus: Path, name: str, plane: int, moves: int) -> None:
    file = corpus / "data" / "public" / "nc" / name
    path = read_program(file.read_bytes(), "linuxcnc", name).run(plane=plane)
    judged = interpret(file, tools=[Tool(1)], startup=LATHE_STARTUP.replace("G18", f"G{plane}"))
    assert len(path) == moves
    assert_same_moves(path, judged)


@pytest.mark.parametrize(
    ("name", "dialect", "moves", "cuts", "oddities"),
    [
        ("fanuc-lathe-round-head-plug.nc", "fanuc-lathe", 51 + 16 * 5, 22 + 16, 13),  # G76: 16 passes of 5 moves
        ("fanuc-lathe-weld-pin.nc", "fanuc-lathe", 28 + 16 * 5 + 2 * 140 + 1, 7 + 16 + 140, 9),  # G75: 140 pecks
        ("fanuc-mill-nims.nc", "fanuc-mill", 200, 97, 15),
    ],
)
def test_shop_programs_of_fanuc_controls(
    corpus: Path, name: str, dialect: str, moves: int, cuts: int, oddities: int
) -> None:
    """Every word is known, every byte kept, and what is not in the path is said with its place."""
    source = (corpus / "data" / "public" / "nc" / name).read_bytes()
    program = read_program(source, dialect, name)
    path = program.run(roughing=False)
    assert program.core.source() == source
    assert program.findings == ()
    assert (len(path), int((~path.rapid).sum())) == (moves, cuts)
    codes = {finding.code for finding in path.findings}
    assert len(path.findings) == oddities
    assert codes == {Code.NC_OPAQUE, Code.NC_MISPLACED}  # G28 names no axis
    assert all(finding.place.line and finding.place.column for finding in path.findings)


@pytest.mark.parametrize(
    ("name", "cycles"),
    [
        (
            "fanuc-lathe-round-head-plug.nc",
            {27: (10, 20, 0.8, 0.1), 75: (30, 40, 0.8, 0.1), 105: (50, 60, 0.65, -0.745)},
        ),
        ("fanuc-lathe-weld-pin.nc", {23: (10, 20, 0.75, 0.1)}),
    ],
)
def test_shop_programs_are_roughed_as_defined(
    corpus: Path, name: str, cycles: dict[int, tuple[int, int, float, float]]
) -> None:
    """Of each G71 (its line): P and Q, and where the tool stands (radius and z, inch).

    Its contour is run by itself; the third has a pocket. Cylinders lie at the height of levels.
    """
    source = (corpus / "data" / "public" / "nc" / name).read_bytes()
    program = read_program(source, "fanuc-lathe", name)
    path = program.run()
    assert {int(line) for line in path.line[np.isin(path.line, [*cycles])]} == set(cycles)
    for line, (first, last, x, z) in cycles.items():
        words = {word.letter: word.value for word in program.block(line - 1).words}
        text = source.decode().splitlines()
        begin, end = (next(k for k, row in enumerate(text) if row.startswith(f"N{n} ")) for n in (first, last))
        own = read_program(
            "\n".join(["G20 G18", f"G00 X{2 * x:.4f} Z{z:.4f}", *text[begin : end + 1]]).encode(), "fanuc-lathe"
        ).run()
        shape = [piece_of(own, k, x * 25.4, z * 25.4) for k in range(1, len(own) - 1)]
        off = (x * 25.4 + words["U"] / 2 * 25.4, z * 25.4 + words["W"] * 25.4)
        cut = sampled(path, np.flatnonzero(path.line == line)[1:-1].tolist())
        moves = [(kind, np.column_stack([off[1] - points[:, 2], off[0] - points[:, 0]])) for kind, points in cut]
        assert_cleared(moves, shape, words["D"] * 25.4, stock_first=False, ordered=False)


def piece_of(path: ToolPath, k: int, x: float, z: float) -> Piece:
    """A move as (deep, along) from where a cycle starts."""
    (x0, _, z0), (x1, _, z1), (cx, _, cz) = path.start_mm[k], path.end_mm[k], path.centre_mm[k]
    return Piece((x - x0, z - z0), (x - x1, z - z1), (x - cx, z - cz) if path.motion[k] == Motion.ARC else None)


def test_the_finish_pass_of_a_shaft_is_its_contour(corpus: Path) -> None:
    """O2004's first finish pass, radii in inch, copied by hand from its blocks P0 to P7."""
    name = "fanuc-lathe-round-head-plug.nc"
    path = read_program((corpus / "data" / "public" / "nc" / name).read_bytes(), "fanuc-lathe", name).run()
    finish = (path.line >= 29) & (path.line <= 37)
    assert path.end_mm[finish][:, [0, 2]] / 25.4 == pytest.approx(
        np.array(
            [
                *([-0.031, 0.0], [0.4109, 0.0], [0.425, -0.0141], [0.425, -0.95], [0.475, -1.0]),
                *([0.6, -1.0], [0.65, -1.05], [0.65, -2.05], [0.8, -2.05]),
            ]
        ),
        abs=1e-12,
    )
    assert (path.compensation[finish] == 42).all()
    assert path.feed[finish] == pytest.approx(0.001 * 25.4)


def test_linuxcncs_own_sample_of_nose_compensation(corpus: Path) -> None:
    """G41 and G42, one tool after the other."""
    file = corpus / "data" / "public" / "nc" / "linuxcnc-lathe-comp.ngc"
    table = [Tool(2, 0.8, 2), Tool(7, 0.4, 3), Tool(9)]
    tools = [CutterTool(tool.nose_radius_mm, tool.orientation, tool.number) for tool in table]
    path = read_program(file.read_bytes(), "linuxcnc").run(plane=18, tools=tools)
    assert_same_moves(path, interpret(file, tools=table, startup=LATHE_STARTUP))


def test_every_public_program_is_kept_byte_for_byte_in_every_dialect(corpus: Path) -> None:
    files = sorted((corpus / "data" / "public" / "nc").glob("*.n*"))
    assert len(files) >= 6
    for file in files:
        for dialect in DIALECTS:
            assert read_program(file.read_bytes(), dialect).core.source() == file.read_bytes()


def test_the_csv_of_every_program_is_that_of_the_slow_reference(corpus: Path) -> None:
    files = [file for file in sorted((corpus / "data" / "public" / "nc").iterdir()) if file.suffix in (".nc", ".ngc")]
    paths = [
        read_program(file.read_bytes(), dialect).run(strict=False, block_limit=20_000)
        for file in files
        for dialect in ("linuxcnc", "fanuc-lathe", "siemens")
    ]
    assert sum(map(len, paths)) > 1000
    for path in paths:
        assert "".join(csv_text(path)).splitlines() == list(csv_lines(path))
