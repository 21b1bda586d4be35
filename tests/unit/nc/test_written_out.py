"""Corners, angles and arcs without a centre written out: the blocks that come of it, worked out by hand."""

from collections.abc import Callable

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import rounded_mm
from trueloop.nc.expand.expand import written_out
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import CoordinateState, ToolPath


def run(program: Program) -> ToolPath:
    return program.run(roughing=False)


def with_slashes(program: Program) -> ToolPath:
    return program.run(skipped_blocks=True)


def explicit(text: str, dialect: str, run: Callable[[Program], ToolPath] = run) -> str:
    program = read_program(text.encode(), dialect)
    path = run(program)
    return written_out(program, path, range(len(path)), run).program.source.decode()


def test_a_shoulder_of_a_lathe() -> None:
    """From radius 10 along Z to z = -10: `,R2.` begins at z = -8 and ends at radius 12, X24.; the chamfer of leg 1
    begins at radius 19. A code that acts before the move stays, one that acts after it goes to its end."""
    text = "G21\nG00 X20. Z0.\nN10 G01 Z-10. ,R2. F.1 (SHOULDER) M08\nN20X40.,C1. M09\nN30 Z-30.\n"
    assert explicit(text, "fanuc-lathe") == (
        "G21\nG00 X20. Z0.\nN10 G01 Z-8.000 F.1 (SHOULDER) M08\nN11 G02 X24.000 Z-10.000 R2.000\n"
        "N20G01 X38.000\nN21 X40.000 Z-11.000 M09\nN30 Z-30.\n"
    )


def test_lines_by_their_angle() -> None:
    """The first line has neither coordinate: along -Z at radius 10 it meets the line at 135° to (radius 20, z -20) at
    z = -10. The other rises at 120° from there by 5 on the radius: 5 / tan 60° = 2.887 further on."""
    text = "G21\nG00 X20. Z0.\nG01 A180. F.1\nX40. Z-20. A135.\nX50. A120.\n"
    assert explicit(text, "haas-lathe") == ("G21\nG00 X20. Z0.\nG01 X20.000 Z-10.000 F.1\nX40. Z-20.\nX50. Z-22.887\n")


def test_increments_about_a_corner_become_positions() -> None:
    """They count from the sharp corner, where the tool then does not come."""
    text = "G21\nG00 X20. Z0.\nG01 W-10.,R2. F.1\nU20.\nW-5.\n"
    assert explicit(text, "fanuc-lathe") == (
        "G21\nG00 X20. Z0.\nG01 Z-8.000 F.1\nG02 X24.000 Z-10.000 R2.000\nG01 X40.000\nW-5.\n"
    )


def test_an_arc_after_a_corner_has_its_centre_from_where_it_starts() -> None:
    """Radius 2 between the line up to (10, 0) and the circle about (10, 10) of radius 10, left of the line and outside
    the circle: centred on x = 8, 12 from (10, 10), so at y = 10 - sqrt(140). It touches at 10/12 of the way there."""
    text = "G21\nG00 X10. Y-20.\nG01 Y0. ,R2. F9.\nG02 X0. Y10. I0. J10.\n"
    assert explicit(text, "fanuc-mill") == (
        "G21\nG00 X10. Y-20.\nG01 Y-1.832 F9.\nG03 X8.333 Y0.140 R2.000\nG02 X0. Y10. I1.667 J9.860\n"
    )


def test_sinumerik_says_the_feed_of_the_next_block_in_the_corner() -> None:
    """Its chamfers are as long as said (CHF, legs of 2/sqrt 2) or have that leg (CHR)."""
    text = "G71 G17 G90\nG1 X10 Y0 RND=2 F100\nY10 F50 CHF=2\nX0 CHR=1\nY5\n"
    assert explicit(text, "siemens") == (
        "G71 G17 G90\nG1 X8.0000 Y0 F100\nG3 X10.0000 Y2.0000 CR=2.0000 F50.\nG1 Y8.5858 F50\n"
        "X8.5858 Y10.0000\nX1.0000\nX0.0000 Y9.0000\nY5\n"
    )


def test_arcs_of_sinumerik() -> None:
    """A quarter of radius 5; the tangent arc from (5, 10) along +x to (15, 15): r = 125 / 10; a half circle about
    (25, 10); from the pole's 45° to 90°."""
    text = (
        "G71 G17 G90\nG0 X0 Y5\nG2 X5 Y10 AR=90 F100\nCT X15 Y15\nG1 X20 Y10\nCIP X30 Y10 I1=25 J1=15\n"
        "G111 X0 Y0\nG1 AP=45 RP=30\nG3 AP=90\nG1 ANG=180 X-5\n"
    )
    assert explicit(text, "siemens") == (
        "G71 G17 G90\nG0 X0 Y5\nG2 X5 Y10 CR=5.0000 F100\nG3 X15 Y15 CR=12.5000\nG1 X20 Y10\n"
        "G2 X30 Y10 I5.0000 J0.0000\n"
        "G111 X0 Y0\nG1 X21.2132 Y21.2132\nG3 X0.0000 Y30.0000 CR=30.0000\nG1 Y30.0000 X-5\n"
    )


def test_a_rounding_of_every_corner_ends_with_its_last() -> None:
    """One that stayed in force would round the corners that are left."""
    text = "G71 G17 G90\nRNDM=2\nG1 X10 Y0 F100\nY10\nX0 M8\nRNDM=0\nY5\n"
    assert explicit(text, "siemens") == (
        "G71 G17 G90\n\nG1 X8.0000 Y0 F100\nG3 X10.0000 Y2.0000 CR=2.0000\nG1 Y8.0000\n"
        "G3 X8.0000 Y10.0000 CR=2.0000\nG1 X2.0000 M8\nG3 X0.0000 Y8.0000 CR=2.0000\n\nG1 Y5\n"
    )
    program = read_program(text.encode(), "siemens")
    assert written_out(program, run(program), [2], run).program.source.decode() == explicit(text, "siemens")


def test_klartext() -> None:
    """F beside RND is its own alone. A tangent arc of more than 120° goes about a CC."""
    text = (
        "0 BEGIN PGM A MM\n1 L X+10 Y+0 F100\n2 RND R2 F50\n3 L Y+10\n4 CHF 1\n5 L IX+20\n6 CT X+40 Y+15\n"
        "7 CC X+40 Y+25\n8 CP IPA+90 DR+\n9 LP PR+15 PA+90\n10 L X+30\n11 CT X+30 Y+60\n12 L X+0\n"
    )
    assert explicit(text, "heidenhain") == (
        "0 BEGIN PGM A MM\n1 L X+8.0000 Y+0 F100\n2 CR X+10.0000 Y+2.0000 R+2.0000 DR+ F50\n3 L Y+9.0000 F100\n"
        "4 L X+11.0000 Y+10.0000\n5 L X+30.0000\n6 CR X+40 Y+15 R+12.5000 DR+\n7 CC X+40 Y+25\n"
        "8 CR X+50.0000 Y+25.0000 R+10.0000 DR+\n9 L X+40.0000 Y+40.0000\n10 L X+30\n"
        "11 CC X+30.0000 Y+50.0000\nC X+30 Y+60 DR-\n12 L X+0\n"
    )


def test_the_block_after_a_tangent_arc_of_klartext_stays() -> None:
    """From (0, 0) along X, the arc to (10, 10) has the radius 10."""
    text = "BEGIN PGM A MM\nTOOL CALL 1 Z S1\nL X-9 Y+0 Z+5 R0 F9\nL X+0\nCT X+10 Y+10\nL M140 MB MAX\nEND PGM A MM\n"
    assert explicit(text, "heidenhain").splitlines()[4:6] == ["CR X+10 Y+10 R+10.0000 DR+", "L M140 MB MAX"]


def test_an_arc_of_klartext_in_another_plane_goes_about_a_pole() -> None:
    """CR stays across the tool's axis: a quarter from (10, 5, -1) about (12, -1) in ZX ends at (12, -3)."""
    text = "BEGIN PGM A MM\nTOOL CALL 1 Z S1\nL X+10 Y+5 Z-1 R0 F9\nCC X+12 Z-1\nCP IPA-90 DR-\nLP PR+4 PA+0\n"
    written = explicit(text + "END PGM A MM\n", "heidenhain").splitlines()
    assert written[3:6] == ["CC X+12 Z-1", "C X+12.0000 Z-3.0000 DR-", "L X+12.0000 Z+3.0000"]


def test_a_sharp_corner_of_klartext_goes_about_a_pole() -> None:
    """The way turns by 180° - atan(4/3) = 126.87°: the rounding begins tan(63.43°) = 2 before (20, 0), about (18, -1),
    and ends 2 along (-3, -4) / 5 from there."""
    text = "0 BEGIN PGM A MM\n1 L X+0 Y+0 F100\n2 L X+20\n3 RND R1\n4 L X+14 Y-8\n"
    assert explicit(text, "heidenhain") == (
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 F100\n2 L X+18.0000\n"
        "3 CC X+18.0000 Y-1.0000\nC X+18.8000 Y-1.6000 DR-\n4 L X+14 Y-8\n"
    )


def test_holes_at_polar_places_become_positions_and_the_code_of_polar_words_goes() -> None:
    """100 mm from the zero at 90 and 180 degrees, then 60 degrees on by an increment; the cycle's words stay."""
    text = (
        "G21 G17 G90 G00 Z9.\nG16 G99 G81 X100. Y90. Z-4. R3. F150.\nY180. M08\nG91 Y60.\nG90 G15 G80\nG01 X20. Y5.\n"
    )
    assert explicit(text, "fanuc-mill") == (
        "G21 G17 G90 G00 Z9.\n G99 G81 X0.000 Y100.000 Z-4. R3. F150.\nX-100.000 Y0.000 M08\nG91 X50.000 Y-86.603\n"
        "G90 G15 G80\nG01 X20. Y5.\n"
    )
    modal = "G17 G71 G90 G0 X0 Y0 Z9 F99\nG111 X20 Y20\nMCALL CYCLE82(50,0,2,-10,,1)\nAP=0 RP=15\nAP=IC(90)\nMCALL\n"
    assert explicit(modal, "siemens").splitlines()[3:5] == ["X35.0000 Y20.0000", "X20.0000 Y35.0000"]


def test_a_program_without_any_stays() -> None:
    text = "G21\nG00 X20. Z0.\nG01 Z-10. F.1\nG02 X24. Z-12. R2.\nX30. Z-15. I3. K0.\n"
    assert explicit(text, "fanuc-lathe") == text


@pytest.mark.parametrize(
    ("text", "dialect", "line", "why"),
    [
        ("G21 #1=9.\nG1 X#1 Y0. F9.\nX10. ,R1.\nY10.", "fanuc-mill", 3, "it depends on X#1"),
        ("G21 #1=9.\nG1 X1. Y0. F9.\nX10. ,R1.\nY#1", "fanuc-mill", 3, "it depends on Y#1"),
        ("G21 #1=1.\nG1 X1. Y0. F9.\nX10. ,R#1\nY9.", "fanuc-mill", 3, "it depends on ,R#1"),
        ("G21 G91\nG1 X1. Y0. F9.\nG93 X10. ,R1. F2.\nY10. F2.", "fanuc-mill", 3, "G93"),
        ("G21 G93 G1 X1. Y0. F9.\nX10. ,R1. F9.\nY10. F9.", "fanuc-mill", 2, "the time of its move is given"),
        ("G21 G1 X1. Y0. F9.\nX10. ,R1. M77\nY10.", "fanuc-mill", 2, "before or after the move"),
        ("G71 RNDM=1\nG1 X9 Y0 F9\nY9\nGOTOF END\nX20\nEND:\nX0", "siemens", 5, "may be in force here"),
        ("G71 G1 X0 Y0 F9\nR1=1\nWHILE R1<3\nX10 RND=R1\nY9\nX0 Y0\nR1=R1+1\nENDWHILE", "siemens", 4, "on RND=R1"),
    ],
)
def test_what_cannot_be_written_out_is_refused(text: str, dialect: str, line: int, why: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        explicit(text, dialect)
    assert refused.value.code is Code.NC_EDIT and why in refused.value.message
    assert refused.value.place.line == line and refused.value.hint


def test_a_corner_that_a_loop_runs_to_different_places_is_refused() -> None:
    """The second time the tool comes from elsewhere: the rounding begins at another place."""
    text = "G71 G1 X0 Y0 F9\nFOR R1=1 TO 2\nX10 Y5 RND=1\nX20 Y9\nX0 Y30\nENDFOR\n"
    with pytest.raises(TrueloopError, match="runs several times to different places") as refused:
        explicit(text, "siemens")
    assert refused.value.place.line == 3


def test_a_corner_in_an_optional_block_is_refused() -> None:
    """Its new blocks would have to be optional as well, and the next one begin elsewhere without them."""
    with pytest.raises(TrueloopError, match="optional block") as refused:
        explicit("G21 G1 X1. Y0. F9.\n/X10. ,R1.\nY10.", "fanuc-mill", with_slashes)
    assert refused.value.code is Code.NC_EDIT and refused.value.place.line == 2


def test_a_diameter_is_rounded_to_the_step_of_the_diameter() -> None:
    """Radius 10.00065 is X20.0013 there, so X20.001; as a radius it would be X10.001."""
    dialect = read_program(b"", "fanuc-lathe").dialect
    found = [rounded_mm(dialect, "X", 10.00065, CoordinateState(False, diameter)) for diameter in (True, False)]
    assert found == pytest.approx([10.0005, 10.001], abs=1e-12)
