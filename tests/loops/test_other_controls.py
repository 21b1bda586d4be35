"""The same part, touches and programs in another control's words: the correction is the same."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.standoff import feed_moves_of, standoff_mm
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.program import read_program

ROOT = Path(__file__).parents[2]
WITHIN_MM = 0.0002


def corrected(job: Path) -> tuple[Correction, Array]:
    """The correction, and how far the contour deviates from the nominal at the touches in its corrected program."""
    inputs = read_job(job).inputs
    correction = compensate(inputs)
    program = read_program(correction.corrected_program, correction.dialect)
    moves = feed_moves_of(program.run(inputs.parameters))
    pairs = zip(correction.touches.nominal_mm, correction.touches.outward_normal, strict=True)
    stands = [standoff_mm(moves, point, normal, correction.nose_radius_mm) for point, normal in pairs]
    return correction, np.array(stands)


@pytest.mark.parametrize("control", ["siemens"])
def test_the_corrected_contour_is_that_of_the_ge_2000t(control: str) -> None:
    correction, stands = corrected(ROOT / "tests" / "loops" / control / "job.toml")
    _, wanted = corrected(ROOT / "examples" / "modbas2" / "job.toml")
    assert correction.dialect == control
    assert np.abs(stands - wanted).max() < WITHIN_MM
    assert np.abs(stands).max() > 0.05  # it is corrected at all


DOME = "G2 X0 Z.03125 CR=R46/2-0.3+0.03125"
FACE_END = "G1 X=R46-0.6+GAP Z=-1.5+R50"


def siemens_job(folder: Path, before: str, after: str) -> Path:
    """The job of this control with some text of its finish program written otherwise."""
    source = ROOT / "tests" / "loops" / "siemens"
    for file in source.iterdir():
        if file.is_file():
            shutil.copy(file, folder)
    job, finish = folder / "job.toml", folder / "finish.mpf"
    job.write_text(job.read_text().replace("../../../examples", str(ROOT / "examples")))
    text = finish.read_text()
    assert before in text
    finish.write_text(text.replace(before, after))
    return job


def test_a_centre_given_as_a_position_is_written_anew(tmp_path: Path) -> None:
    """The old words are gone: the contour is that of the program with a radius."""
    job = siemens_job(tmp_path, DOME, "G2 X0 Z.03125 I=AC(0) K=AC(-1.46)")
    correction, stands = corrected(job)
    _, wanted = corrected(ROOT / "tests" / "loops" / "siemens" / "job.toml")
    assert np.abs(stands - wanted).max() < WITHIN_MM
    assert b"AC(0)" not in correction.corrected_program


PLAIN = {
    DOME: "G2 X0 Z.03125 CR=1.49125",
    "X=R46+2.2+GAP": "X5.7825",
    "Z=ZERO+R50": "Z-6.40375",
    "Z=(-6.14375+R50)": "Z-6.10375",
    "Z=-6.14375+R50": "Z-6.10375",
    "X=R46+1.8+0.03684": "X5.35684",
    "X=R46+GAP Z=-4.54192+R47+R50": "X3.5825 Z-4.50192",
    "X=R46+GAP Z=AC(-1.76875+R50)": "X3.5825 Z-1.72875",
    "X=R46-0.6+GAP Z=-1.76875+R50": "X2.9825 Z-1.72875",
    FACE_END: "G1 X2.9825 Z-1.46",
}
"""The formulas of the finish program as the numbers that they make."""
PLAIN_DOME, PLAIN_FACE_END = PLAIN[DOME], PLAIN[FACE_END]
SHAPED = [
    (DOME, "G2 X0 Z.03125 AR=90"),
    (DOME, "CT X0 Z.03125"),
    (DOME, "CIP X0 Z.03125 I1=2.10895 K1=-0.40553"),
    (DOME, "G111 X0 Z-1.46\nG2 AP=0 RP=1.49125"),
    (FACE_END, "G1 ANG=0 Z=-1.5+R50"),
]
"""The dome and the end of the cylinder before it in words that say neither radius, centre nor end."""


def plain(text: str) -> str:
    for formula, number in PLAIN.items():
        text = text.replace(formula, number)
    return text.replace("Z=-1.5+R50", "Z-1.46")


@pytest.mark.parametrize(("before", "after"), SHAPED)
def test_a_move_that_other_words_shape_is_written_out_and_corrected(tmp_path: Path, before: str, after: str) -> None:
    job = siemens_job(tmp_path, DOME, DOME)
    finish = tmp_path / "finish.mpf"
    finish.write_text(plain(finish.read_text()).replace(PLAIN[before], plain(after)))
    correction, stands = corrected(job)
    _, wanted = corrected(ROOT / "examples" / "modbas2" / "job.toml")
    assert np.abs(stands - wanted).max() < WITHIN_MM
    assert np.abs(stands).max() > 0.05
    assert plain(after).encode() not in correction.corrected_program
    assert correction.corrected_program.splitlines()[4:12] == finish.read_bytes().splitlines()[2:10]


@pytest.mark.parametrize(("before", "after"), SHAPED)
def test_a_move_that_other_words_shape_is_refused_beside_formulas(tmp_path: Path, before: str, after: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        corrected(siemens_job(tmp_path, before, after))
    assert refused.value.code == Code.NC_EDIT, refused.value
    assert "it depends on X=R46-0.6+GAP, which another value would change" in refused.value.message
    assert refused.value.place.line is not None
    assert refused.value.hint


def test_a_program_that_leaves_diameters_to_machine_data_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as refused:
        corrected(siemens_job(tmp_path, " DIAMON", ""))
    assert refused.value.code == Code.NC_DIAMETER, refused.value
