"""A contour that CYCLE95 roughs and finishes, corrected once: LinuxCNC's interpreter keeps the nose off and judges."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_contour_under_g42 import intended_mm, moved_mm, touches_on
from tests.loops.test_roughing_choice import passes, same
from tests.support.correction import NOW
from trueloop.domain.part import PartType
from trueloop.errors import Code, TrueloopError
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.program import read_program
from trueloop.turned.options import Options, Roughing

NOSE_MM = 0.4
CONTOUR = "N200 G1 X20 Z2\nN210 Z-10\nN220 X26 Z-15\nN230 Z-25\nN240 G2 X36 Z-30 CR=5\nN250 G1 X50\nN260 Z-45\n"
SUBPROGRAM = '"PART"', f"%_N_PART_SPF\n{CONTOUR}N270 M17\n"
LABELS = '"ANF:ENDE"', f"ANF:\n{CONTOUR}ENDE:\n"


def program(form: tuple[str, str], roughing: int = 1, finishing: int = 5) -> bytes:
    name, contour = form
    text = (
        "%_N_SHAFT_MPF\nN10 G18 G71 G90 G95 DIAMON G54\nN20 T1 D1\nN30 G96 S200 M4\nN40 G0 X60 Z5\n"
        f"N50 CYCLE95({name},2.5,0.1,0.2,,0.3,0.1,0.15,{roughing},,,1)\nN60 G0 X100 Z80\nN70 T2 D1\nN80 G0 X60 Z5\n"
        f"N90 CYCLE95({name},2.5,,,,0.3,0.1,0.15,{finishing},,,1)\nN100 G0 X100 Z80\nN110 M30\n{contour}"
    )
    return text.encode()


def corrected(source: bytes, roughing: Roughing) -> Correction:
    read = read_program(source, "siemens", "shaft.mpf")
    profile = contour_of_program(feed_moves(read.run(roughing=False)), NOSE_MM).profile
    touches = touches_on(profile)
    touches = replace(touches, error_mm=0.02 + 0.3 * touches.error_mm)
    options = Options(roughing=roughing, by="contour")
    return compensate(Inputs(PartType("shaft"), profile, NOSE_MM, read, touches, options, NOW))


def in_linuxcncs_words(source: str, head: str) -> str:
    """The contour's blocks behind that line, run by LinuxCNC under G42: CR= is its R."""
    lines = source[source.index(head) + len(head) :].splitlines()
    moves = [line for line in lines if re.match(r"(N\d+ )?(G[0-3]\b|[XZ])", line)]
    blocks = [re.sub(r"^N\d+ ", "", line).replace("CR=", "R") for line in moves]
    first, *rest = blocks[: next((k for k in range(1, len(blocks)) if blocks[k].startswith("G1 X20 Z2")), None)]
    approach = f"G0 {first.removeprefix('G1 ')}"
    return "\n".join(["G21 G7 G18 G40 G90 G94 F10 T1 M6", "G0 X52 Z4", "G42", approach, "G1", *rest, "G40", "M2", ""])


@pytest.mark.parametrize("form", [SUBPROGRAM, LABELS], ids=["subprogram", "labels"])
@pytest.mark.parametrize("roughing", ["moves", "stays"])
def test_the_contour_is_corrected_once(form: tuple[str, str], roughing: Roughing, tmp_path: Path) -> None:
    source = program(form)
    found = corrected(source, roughing)
    written = found.corrected_program.decode()
    stays = roughing == "stays"
    head = {True: {"PART": "%_N_PART_2_SPF\n", "ANF": "ANF_2:\n"}, False: {"PART": "%_N_PART_SPF\n", "ANF": "ANF:\n"}}
    text = in_linuxcncs_words(written, next(line for name, line in head[stays].items() if name in form[0]))
    off_mm = moved_mm(found, text, tmp_path) - intended_mm(found)
    assert np.abs(off_mm).max() < 0.0002 + 0.0005 and np.abs(intended_mm(found)).max() > 0.015
    before, after = (passes(read_program(text, "siemens")) for text in (source, found.corrected_program))
    assert len(before) > 30
    assert (written.count(CONTOUR) == 1) == stays
    if stays:
        assert same(after, before)
        assert any("line 6 cuts what it cut before" in note for note in found.notes)
    else:
        assert min(row[1] for row in after) < min(row[1] for row in before) - 0.01
        assert any("line 6 runs on the blocks" in note for note in found.notes)


def test_a_cycle_that_does_both_moves_whole_or_is_refused() -> None:
    whole = program(SUBPROGRAM, roughing=1, finishing=9)
    with pytest.raises(TrueloopError) as refused:
        corrected(whole, "stays")
    assert refused.value.code is Code.NC_EDIT and refused.value.place.line == 10
    assert b"PART_2" not in corrected(whole, "moves").corrected_program


def test_roughing_and_finishing_of_an_earlier_cycle62_cannot_be_parted() -> None:
    text = program(SUBPROGRAM).decode().splitlines()
    text[5], text[9] = 'CYCLE62("PART",0,,)\nCYCLE952("A","","",101311,0.3)', 'CYCLE952("B","","",101321,0.15)'
    source = "\n".join([*text, ""]).encode()
    with pytest.raises(TrueloopError) as refused:
        corrected(source, "stays")
    assert refused.value.code is Code.NC_EDIT and refused.value.place.line == 11
    assert corrected(source, "moves").corrected_program != source
