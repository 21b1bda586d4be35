"""Where a program cuts on its surface: its shifts and the job's zero count; a zero that is not known is refused.

The corrected surface leans by 1 µm/mm along x and the nominal one lies at z 0, so a ball whose tip is at x goes to
z = x/1000 (its flank adds 3 mm · (√(1 + 10⁻⁶) − 1), 1.5 nm).
"""

import re
from dataclasses import replace

import pytest

from tests.support.surfaces import wavy_surface
from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import read_program
from trueloop.surface.compensation.cutter import Cutter
from trueloop.surface.compensation.placed import require_outer_side
from trueloop.surface.compensation.program import corrected_program
from trueloop.surface.compensation.shift import SurfaceJob

FLAT = wavy_surface(20.0, 0.0)
LEANING = replace(FLAT, control_mm=FLAT.control_mm + FLAT.control_mm[..., :1] * [0.0, 0.0, 0.001])
BALL = SurfaceJob(Cutter(3.0, 3.0))
START = "G21 G90 G94 G17 G54\nG0 X2. Y10. Z5.\n"
CUT = "G1 X{0} Z0. F100.\nX{1}\nG0 Z5.\n"


def _written(text: str, dialect: str = "fanuc-mill", job: SurfaceJob = BALL) -> str:
    return corrected_program(
        read_program(text.encode(), dialect), FLAT, LEANING, job, "0123456789abcdef"
    ).source.decode()


def _heights(written: str) -> list[float]:
    """Returns the Z words of the cutting blocks, in order."""
    lines = (
        line for line in written.splitlines() if not re.search(r"G0\b|FMAX|TRANS|TOOL|7\.|G52|BEGIN|corrected", line)
    )
    return [float(word) for line in lines for word in re.findall(r"Z\+?(-?[\d.]+)", line)]


SIEMENS = (
    "G71 G90 G94 G17 G54\nG0 X2 Y10 Z5\n{0}\nG0 X0 Y10\nG1 X0 Z0 F100\nX6\nG0 Z5\n{1}\nG0 X2 Y10\nG1 Z0\nG0 Z5\nM30\n"
)
KLARTEXT = (
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S8000\n2 L X+2 Y+10 Z+5 R0 FMAX\n3 CYCL DEF 7.0 NULLPUNKT\n4 CYCL DEF 7.1 X+10\n"
    "5 L X+0 Y+10 R0 FMAX\n6 L Z+0 R0 F100\n7 L X+6\n8 L Z+5 R0 FMAX\n9 CYCL DEF 7.0 NULLPUNKT\n10 CYCL DEF 7.1 X+0\n"
    "11 L X+2 Y+10 R0 FMAX\n12 L Z+0 R0 F100\n13 L Z+5 R0 FMAX\n14 END PGM A MM\n"
)


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        (
            f"{START}G52 X10.\nG0 X0. Y10.\n{CUT.format('0.', '6.')}G52 X0\nG0 X2. Y10.\nG1 Z0.\nG0 Z5.\nM30\n",
            "fanuc-mill",
        ),
        (SIEMENS.format("TRANS X10", "TRANS"), "siemens"),
        (SIEMENS.format("TRANS X4\nATRANS X6", "ATRANS X-10"), "siemens"),
        (KLARTEXT, "heidenhain"),
    ],
)
def test_the_programs_own_shift_is_followed(text: str, dialect: str) -> None:
    """Local 0 and 6 under a shift of 10 lie at x 10 and 16; after it x 2 is x 2."""
    assert _heights(_written(text, dialect)) == [0.010, 0.016, 0.002]


def test_a_surface_is_found_where_the_shift_puts_the_cut() -> None:
    """Beside the patch in its own numbers (x −95 to −90), on it at x 5 to 10 with G52 X100."""
    assert _heights(_written(f"{START}G52 X100.\nG0 X-95. Y10.\n{CUT.format('-95.', '-90.')}M30\n")) == [0.005, 0.010]


def test_the_zero_of_the_program_is_the_jobs() -> None:
    """A work zero 3 mm beside and 2 mm above that of the surface: x 5 is x 8, and Z −2 is on the surface."""
    job = replace(BALL, zero_mm=(3.0, 0.0, 2.0))
    text = f"{START}G1 X5. Z-2. F100.\nX11.\nG0 Z5.\nM30\n"
    assert _heights(_written(text, job=job)) == [-1.992, -1.986]
    with pytest.raises(TrueloopError, match="from its inner side"):
        require_outer_side(read_program(text.encode(), "fanuc-mill"), FLAT.turned_over(), job)


TWO = f"{START}{CUT.format('4.', '8.')}G55\nG0 X2. Y10. Z5.\n{CUT.format('4.', '8.')}M30\n"


@pytest.mark.parametrize(
    ("text", "what", "line"),
    [
        (TWO, "cuts in 2 work offsets", 8),
        (
            f"{START}{CUT.format('4.', '8.')}G10 L2 P1 X9. Y0 Z0\n{CUT.format('4.', '8.')}M30\n",
            "changes the work offset",
            7,
        ),
        (f"{START}G92 X0.\n{CUT.format('4.', '8.')}M30\n", "only the control knows", 4),
        (
            f"G21 G90 G94 G17\nG92 X50. Y0 Z50.\nG0 X2. Y10. Z5.\n{CUT.format('4.', '8.')}M30\n",
            "only the control knows",
            4,
        ),
    ],
)
def test_a_zero_that_is_not_known_is_refused(text: str, what: str, line: int) -> None:
    with pytest.raises(TrueloopError, match=what) as told:
        _written(text)
    assert told.value.code is Code.SRF_PROGRAM and told.value.place.line == line


def test_a_probing_cycle_between_the_cuts_may_set_the_zero_anew() -> None:
    probed = KLARTEXT.replace("9 CYCL DEF 7.0", "9 TCH PROBE 412 DATUM ~\n  Q321=+50\n10 CYCL DEF 7.0")
    with pytest.raises(TrueloopError, match="probes between the cuts") as told:
        _written(probed, "heidenhain")
    assert told.value.code is Code.SRF_PROGRAM and told.value.place.line == 10
    before = KLARTEXT.replace("2 L X+2", "2 TCH PROBE 412 DATUM ~\n  Q321=+50\n3 L X+2")
    assert _heights(_written(before, "heidenhain")) == [0.010, 0.016, 0.002]


def test_named_work_offsets_are_corrected_and_others_stay() -> None:
    """The tip at x 4 and 8 goes to z 4 and 8 µm."""
    assert _heights(_written(TWO, job=replace(BALL, work_offsets=("G55",)))) == [0.0, 0.004, 0.008]
    assert _heights(_written(TWO, job=replace(BALL, work_offsets=("G54", "G55")))) == [0.004, 0.008] * 2
    with pytest.raises(TrueloopError, match="not a work offset"):
        _written(TWO, job=replace(BALL, work_offsets=("G5",)))


def test_a_register_set_where_a_cut_left_the_tool_displaced_is_refused() -> None:
    """G92 calls the place 20 µm above z 0 zero: what follows would be 20 µm too high."""
    text = f"{START}G1 X20. Z0. F100.\nG92 Z0.\nG0 Z5.\nM30\n"
    with pytest.raises(TrueloopError, match="left the tool displaced") as told:
        _written(text)
    assert told.value.code is Code.SRF_PROGRAM and told.value.place.line == 5


def test_offsets_set_before_the_first_cut_are_the_programs_zero() -> None:
    assert _heights(_written(f"{START}G10 L2 P1 X9. Y0 Z0\nG0 X2. Y10. Z5.\n{CUT.format('4.', '8.')}M30\n"))[-2:] == [
        0.004,
        0.008,
    ]
