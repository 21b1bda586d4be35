"""The dialect is recognised by its words, and asked for where they leave a doubt."""

from time import process_time

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.guess import guess_dialect, scores


@pytest.mark.parametrize(
    ("text", "file", "dialect"),
    [
        ("G17 G71 G90\nR1=5\nG0 X=R1\nCYCLE800()\nUNKNOWN_CYCLE(1,2)\nM30\n", "a.mpf", "siemens"),
        ("0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1\n2 L X+1 FMAX\n3 FL AN+1\n", None, "heidenhain"),
        ("G21 G90 G0 X1. Y1.\nG1 X2. F100.\nM2\n", "a.ngc", "linuxcnc"),
        ("O1000\nG21 G90 G54 G00 X1. Y1.\nG54.1 P2\nG05.1 Q1\nM30\n", "a.nc", "fanuc-mill"),
        ("O1000\nG21 G90 G54 G00 X1. Y1.\nG154 P2\nG187 P2\nM30\n", "a.nc", "haas-mill"),
        ("G21 G8 G18 G90\nT1 M6\nG1 X20 Z-5 F.1\n", "a.nc", "linuxcnc"),
        ("O1000 (MAZAK QT-200)\nG21\nT001001\nG50 S2000\nG0 X30. Z5.\nG1 Z-20. F0.1\nM30\n", "a.eia", "mazak-lathe"),
        ("O1000 (MELDAS)\nG21 G90 G54 G00 X1. Y1.\nG43 H1 Z5.\nG30.1 Z0.\nM30\n", "a.nc", "mitsubishi-mill"),
        ("G90 G00 X40 Z5\nNLAP1 G81\nG80\nTG=1 OG=1\nM02\n", None, "okuma-lathe"),
    ],
)
def test_the_words_tell_the_dialect(text: str, file: str | None, dialect: str) -> None:
    assert guess_dialect(text.encode(), file) == dialect


def test_what_fanuc_and_haas_write_alike_is_asked_with_the_scores_and_their_reasons() -> None:
    with pytest.raises(TrueloopError) as asked:
        guess_dialect(b"O1000\nG21 G90 G00 X1. Y1.\nG43 H1 Z5.\nM30\n", "a.nc")
    assert asked.value.code is Code.NC_DIALECT
    assert "fanuc-mill 9 points (O1000" in asked.value.message and "haas-mill 9 points" in asked.value.message
    assert "--dialect fanuc-mill" in (asked.value.hint or "")


def test_a_fit_in_a_comment_does_not_make_a_lathe_program_linuxcncs() -> None:
    """Read so, X would be taken for a radius without a word."""
    program = b"(BUSHING 30 G7)\nG21\nT0101\nG97 S1500 M3\nG0 X30. Z5.\nG1 Z-20. F0.1\nM30\n"
    assert scores(program)["linuxcnc"].points == 0


def test_a_long_program_of_plain_blocks_is_scored_in_time_that_grows_with_its_length() -> None:
    """A mark searched from every line to the end of the file would take seconds."""
    source = b"".join(b"X%d.%05d Y-0.00029 Z0.25776\n" % (k % 50, k) for k in range(4000))
    began = process_time()
    scores(source)
    assert process_time() - began < 1.0
