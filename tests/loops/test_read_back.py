"""A writer that goes wrong is caught on reading back: a move too many, a turn the wrong way, an M code too early."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.refusals import refused
from trueloop.errors import Code
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned import written
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.edit.edit import Edit, insert_blocks_after
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.turned.program.write import Displacements, corrected_source

JOB = Path(__file__).parents[2] / "examples" / "linuxcnc" / "job.toml"
DOME, CONE = b"G2 X0 Z0.03125 R[#46/2-0.3+0.03125] (dome)", b"(cone)"


def _block(program: Program, text: bytes) -> int:
    return program.source[: program.source.index(text)].count(b"\n")


def _inputs(dome: bytes | None = None) -> Inputs:
    inputs = read_job(JOB).inputs
    if dome is None:
        return inputs
    source = inputs.program.source.replace(DOME, dome)
    return replace(inputs, program=read_program(source, inputs.program.dialect.name, inputs.program.file))


def test_plunge_and_back_again_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every intended point is still passed; only the written moves show the two that nobody meant."""

    def with_plunge(program: Program, path: ToolPath, targets: Displacements) -> list[Edit]:
        plunge = insert_blocks_after(program, _block(program, CONE), ["G91 X-2", "X2", "G90"])
        return [*corrected_source(program, path, targets), plunge]

    monkeypatch.setattr(written, "corrected_source", with_plunge)
    refusal = refused(lambda: compensate(_inputs()))
    assert refusal.code is Code.CMP_READ_BACK
    assert re.search(r"the written program has \d+ moves, where \d+ are those of the source", refusal.message)


def test_arc_the_long_way_round_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """The circle is the intended one: only the sweep tells that the tool goes through the part."""

    def turned(program: Program, path: ToolPath, targets: Displacements) -> list[Edit]:
        return [
            replace(edit, text=edit.text.replace("G2 ", "G3 ").replace("G02 ", "G03 "))
            for edit in corrected_source(program, path, targets)
        ]

    monkeypatch.setattr(written, "corrected_source", turned)
    inputs = _inputs(b"G2 X0 Z0.03125 I-1.49125 K0 (dome)")
    assert refused(lambda: compensate(inputs)).code is Code.CMP_READ_BACK


def test_codes_that_act_after_the_move_end_the_last_piece() -> None:
    source = compensate(_inputs(DOME.replace(b" (dome)", b" M9 M8 (dome)"))).corrected_program
    pieces = [line for line in source.splitlines() if line.startswith((b"G2 ", b"G3 "))]
    assert len(pieces) > 1
    assert b"M8" in pieces[0] and b"M9" not in pieces[0]
    assert pieces[-1].endswith(b" M9")


@pytest.mark.parametrize(("word", "said"), [(b" M66", "M66"), (b" M10", "M10")])
def test_code_of_unknown_order_is_refused(word: bytes, said: str) -> None:
    refusal = refused(lambda: compensate(_inputs(DOME.replace(b" (dome)", word))))
    assert refusal.code is Code.NC_EDIT and said in refusal.message


def test_timed_arc_is_refused() -> None:
    refusal = refused(lambda: compensate(_inputs(DOME.replace(b"G2 ", b"G93 G2 F3. ") + b"\nG95 F0.005")))
    assert refusal.code is Code.NC_EDIT and "G93" in refusal.message
