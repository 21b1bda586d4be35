"""Every way in which a correction is refused."""

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_contour_under_g42 import touches_on
from trueloop.domain.option import Limits
from trueloop.domain.part import PartType
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.in_force import InForce
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.program import read_program
from trueloop.turned.compensation.displaced import centre_pieces, shifted_contour
from trueloop.turned.compensation.shift import sampled
from trueloop.turned.options import Options
from trueloop.turned.program.read_back import check_contour

JOB = Path(__file__).parents[2] / "examples" / "facetst" / "job.toml"
NOW = datetime(2026, 1, 2, tzinfo=UTC)


def _inputs() -> Inputs:
    return read_job(JOB).inputs


def _limited(limits: Limits) -> None:
    inputs = _inputs()
    compensate(replace(inputs, options=replace(inputs.options, limits=limits)))


def _old() -> None:
    inputs = _inputs()
    (inspection,) = inputs.inspections
    days_ago = replace(inspection, measured_at=NOW - timedelta(days=3))
    compensate(replace(inputs, made_at=NOW, inspections=(days_ago,)))


def _twice() -> None:
    inputs = _inputs()
    once = compensate(inputs).corrected_program
    compensate(replace(inputs, program=read_program(once, "ge2000t", "corrected.nc")))


def _other_program() -> None:
    compensate(replace(_inputs(), program_sha256="0" * 64))


def _rapid_along_the_contour() -> None:
    """The last block leaves along the cylinder at the diameter it inherits, which the correction has made smaller."""
    inputs = _inputs()
    moves = b"G00 X6.3 Z0.1;G01 F.005 X-0.03 Z0.03125;X1.7825;Z-1.96875;X5.6825;Z-3.96875;G00 Z-4.5;M30"
    source = b"G70 G95\n" + moves.replace(b";", b"\n") + b"\n"
    large = inputs.touches.of_feature(inputs.profile.names.index("large-cylinder"))
    error_mm = inputs.touches.error_mm.copy()
    error_mm[large] = 0.05
    touches = replace(inputs.touches, error_mm=error_mm)
    compensate(replace(inputs, touches=touches, program=read_program(source, "ge2000t", "short.nc"), semifinish=None))


def _cut_by_nobody_knows_what() -> None:
    compensate(replace(_inputs(), in_force=InForce(possible=("o1/record.json (319bcb4f5bd4419b)",))))


def _not_as_intended() -> None:
    inputs = _inputs()
    shifts = [sampled(np.array([0.0]), np.array([0.01]))] * len(inputs.profile.features)
    pieces = centre_pieces(inputs.profile, shifted_contour(inputs.profile, shifts, inputs.nose_radius_mm))
    path = inputs.program.run(inputs.parameters)
    check_contour(path, (0, len(path) - 1), pieces, 0.001)


def _roughing_that_stays() -> None:
    """The part is 0.06 mm too small everywhere, and 0.02 mm are left on its radius."""
    source = b"""G21 G18 G40 G99
G00 X60. Z2.
G71 U2. R0.5
G71 P10 Q20 U0.04 W0.02 F0.25
N10 G00 X20.
G01 Z-10. F0.1
X40. Z-15.
N20 Z-45.
G70 P10 Q20
M30
"""
    program = read_program(source, "fanuc-lathe", "plug.nc")
    profile = contour_of_program(feed_moves(program.run(roughing=False)), 0.4, lines=(5, 8)).profile
    touches = touches_on(profile)
    touches = replace(touches, error_mm=-0.06 + 0.3 * touches.error_mm)
    options = Options(roughing="stays", by="contour")
    compensate(Inputs(PartType("plug"), profile, 0.4, program, touches, options, NOW, lines=(5, 8)))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.CMP_SIZE: lambda: _limited(Limits(correction_mm=0.001)),
    Code.CMP_SLOPE: lambda: _limited(Limits(slope=1e-6)),
    Code.CMP_SCATTER: lambda: _limited(Limits(scatter_mm=1e-6)),
    Code.CMP_AGE: _old,
    Code.CMP_TWICE: _twice,
    Code.CMP_OTHER_PROGRAM: _other_program,
    Code.CMP_CUT_WITH: _cut_by_nobody_knows_what,
    Code.CMP_RAPID: _rapid_along_the_contour,
    Code.CMP_STOCK: _roughing_that_stays,
    Code.CMP_READ_BACK: _not_as_intended,
}


@pytest.mark.parametrize(
    ("code", "file"),
    [
        (Code.CMP_SCATTER, "touches.csv"),
        (Code.CMP_AGE, "job.toml"),
        (Code.CMP_RAPID, "short.nc"),
        (Code.CMP_TWICE, "corrected.nc"),
    ],
)
def test_a_refusal_names_the_file_that_the_refused_value_was_read_from(code: Code, file: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        PRODUCERS[code]()
    assert Path(refused.value.place.file or "").name == file
