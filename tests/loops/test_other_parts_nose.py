"""Jobs that name other parts cut with the same edge: their nose serves where it was seen, and only there."""

from pathlib import Path

import numpy as np
import pytest

from scripts.nist_parts import parts
from scripts.nist_table import write_job
from tests.loops import test_setups_in_store
from tests.loops.test_setups_in_store import FLIPPED, errors_um, touches
from tests.support.cli import run
from trueloop.jobs.turned.job import read_cuts, read_job
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate


def corrected(tmp_path: Path, number: str, others: tuple[str, ...]) -> Correction:
    """A published part with the nose of others, by part number."""
    jobs: dict[str, Path] = {}
    for part in parts():
        if part.number in (number, *others):
            (tmp_path / part.number).mkdir()
            jobs[part.number] = write_job(part, tmp_path / part.number)
    listed = ", ".join(f'"../{jobs[other].relative_to(tmp_path)}"' for other in others)
    job = jobs[number]
    job.write_text(job.read_text() + f"\n[compensation]\nnose_from = [{listed}]\n")
    return compensate(read_job(job).inputs)


def test_the_same_edge_on_the_same_shape_is_weighed_by_leave_one_out(tmp_path: Path) -> None:
    """NISTIR 6811 Table 8: 2511 beside the noses of 2611 and 2711; both figures are told."""
    correction = corrected(tmp_path, "2511", ("2611", "2711"))
    (choice,) = correction.model.choices
    assert choice.features == ("dome",)
    assert 0.001 < choice.nose_rms_mm < 0.006
    assert 0.001 < choice.own_rms_mm < 0.006


def test_a_nose_never_seen_at_the_knobs_angles_does_not_serve_it(tmp_path: Path) -> None:
    """A dome shows 86° of the nose; the knob of PIECS11 is cut up to 107°, and nobody saw those."""
    correction = corrected(tmp_path, "3511", ("2511",))
    assert not any(choice.nose_serves for choice in correction.model.choices)
    assert any("contact angles open" in note for note in correction.model.notes)
    knob = correction.touches.of_feature(correction.profile.names.index("knob"))
    assert np.abs(correction.prediction.after_mm[knob]).max() < 0.006


def test_the_nose_is_that_of_one_edge_in_the_clamping_of_its_set_up(tmp_path: Path) -> None:
    """Of a part that three tools cut in two set-ups, what T2 cut: as a job of T2 alone has it, drawn by hand in the
    frame of its program.
    """
    single = test_setups_in_store.alone(tmp_path / "single", FLIPPED)
    others = {"whole": test_setups_in_store.placed(tmp_path / "whole"), "single": single}
    own = touches(errors_um(1), FLIPPED)
    (single.parent / "touches.csv").write_text(own)
    found = []
    for name in others:
        path = test_setups_in_store.alone(tmp_path / f"by-{name}", FLIPPED)
        (path.parent / "touches.csv").write_text(own)
        listed = f'[compensation]\nnose_from = ["../{name}/job.toml"]\n'
        path.write_text(path.read_text().replace("[compensation]\n", listed))
        nose = read_cuts(JobFiles.of(path)).setups[0].cuts[0][1].nose
        assert nose is not None
        found.append(nose.w_mm(np.linspace(nose.lowest_rad, nose.highest_rad, 9)))
    assert found[0] == pytest.approx(found[1], abs=1e-8) and np.ptp(found[0]) > 5e-4
    path.write_text(path.read_text().replace("../single", "../whole").replace("right-hand", "left-over"))
    assert "NC-NO-TOOL" in run("compensate", path, "--no-store", "-o", tmp_path / "no", status=3)
