"""`measure read --after`: what was measured is kept with the cut that it shows, and what cannot be is refused."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke
from tests.support.gauged import shaft_with
from tests.support.job_in_store import EDGE, FINISH, JobInStore, job_in_store
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.jobs.store.history import history_of
from trueloop.storage.store import find


@pytest.fixture
def kept(tmp_path: Path) -> JobInStore:
    """PIECS11's part 3511.158, corrected and kept."""
    return job_in_store(tmp_path)


def test_a_finish_inspection_is_linked_with_its_cut_and_its_correction(kept: JobInStore) -> None:
    said = kept.finish(FINISH, "--order", 3, "--minutes", 3.2)
    assert "trueloop.db: 1 inspection, 1 cut" in said.stdout
    (cut,) = (one.value for one in find(kept.store, Cut, stage=Stage.FINISH))
    assert cut.correction == kept.correction.record.id and cut.order == 3
    assert cut.conditions.time_in_cut_min == 3.2 and cut.conditions.depth_of_cut_mm == 0.254
    assert cut.setting is not None and cut.setting.edge.identity == EDGE.identity
    (part,) = history_of(kept.store, EDGE)
    assert part.finish is not None and part.correction_mm is not None
    assert part.finish.error_mm == pytest.approx(FINISH[1:] * 1e-3, abs=1e-9)
    assert len(part.semifinish.point) == 25 and np.max(np.abs(part.correction_mm)) > 0.01


def test_the_same_file_twice_has_no_second_row(kept: JobInStore) -> None:
    kept.finish(FINISH, "--order", 3)
    assert "all of it is kept already" in kept.finish(FINISH).stdout
    assert len(find(kept.store, Inspection)) == 2 and len(find(kept.store, InspectionLink)) == 2


@pytest.mark.parametrize(
    ("ran", "program"), [("corrected", "corrected.nc"), ("offsets", "offsets.nc"), ("as-programmed", "../finish.nc")]
)
def test_what_ran_is_said_by_a_word_or_by_the_program_itself(kept: JobInStore, ran: str, program: str) -> None:
    """Both ways the cut ran the same text; as programmed it has no correction."""
    kept.finish(FINISH, "--ran", ran)
    (by_word,) = (one.value for one in find(kept.store, Cut, stage=Stage.FINISH))
    kept.finish(FINISH, "--program", kept.folder / "out" / program, "--supersede")
    (by_text,) = (one.value for one in find(kept.store, Cut, stage=Stage.FINISH))
    assert by_word == by_text and (by_word.correction == "") == (ran == "as-programmed")


def test_a_correction_that_was_not_run_takes_nothing_off(kept: JobInStore) -> None:
    kept.finish(FINISH, "--ran", "as-programmed")
    (part,) = history_of(kept.store, EDGE)
    assert part.correction_mm == pytest.approx(0.0, abs=1e-3)


def test_a_program_that_was_changed_at_the_control_is_warned_of_and_kept(kept: JobInStore) -> None:
    program = kept.folder / "as-read-back.nc"
    program.write_bytes((kept.folder / "out" / "corrected.nc").read_bytes().replace(b"F", b"F ", 1) + b"\n")
    said = kept.finish(FINISH, "--program", program)
    assert "warning STO-PROGRAM" in said.stderr and "1 inspection, 1 cut, 1 program" in said.stdout


def test_the_next_piece_of_a_file_is_not_kept_as_the_part_of_the_job(tmp_path: Path) -> None:
    """Piece A1 and one without a serial number; `--run 1`, as the hint has it, keeps that of A1 alone."""
    lines = ["K0100 1", "K1002 SHAFT", "K2001/1 1", "K2002/1 Durchmesser 44", "K2101/1 44", "K2142/1 mm"]
    values = ["44.031\x140\x1419.04.2026/19:08:00", "K0014/0 A1", "44.051\x140\x1419.04.2026/19:11:00"]
    (tmp_path / "two.dfq").write_text("\n".join([*lines, *values]) + "\n")
    job = shaft_with(tmp_path, "feature,z_mm,diameter_mm\nseat-44,-85,44.02\n", 'serial = "A1"\n', "part")
    invoke("compensate", job, status=0)
    keep = "measure", "read", tmp_path / "two.dfq", "--after", "finish", "--job", job
    refused = invoke(*keep, status=3).stderr
    assert "MSR-SERIAL" in refused and "1 inspections of an unknown part" in refused and "--run N" in refused
    assert "1 inspection" in invoke(*keep, "--run", 1, status=0).stdout


def test_a_measuring_machine_off_the_machine_counts_after_the_inspection_on_it(kept: JobInStore) -> None:
    kept.finish(FINISH + 5.0 * (FINISH != 0.0), after="released")
    (released,) = history_of(kept.store, EDGE)
    assert released.finish is not None and released.finish.error_mm[0] == pytest.approx(1e-3 * (FINISH[1] + 5.0))
    kept.finish(FINISH)
    kept.finish(FINISH + 6.0 * (FINISH != 0.0), after="released")
    (part,) = history_of(kept.store, EDGE)
    assert part.finish is not None and part.finish.error_mm[0] == pytest.approx(1e-3 * FINISH[1])
    assert len(find(kept.store, Cut, stage=Stage.FINISH)) == 1


def other_part(kept: JobInStore) -> None:
    kept.finish(FINISH)
    kept.finish(FINISH, serial="3611.154", status=3)


def of_no_correction(kept: JobInStore) -> None:
    kept.finish(FINISH, serial="3611.154", status=3)


def another_parts_record(kept: JobInStore) -> None:
    kept.finish(FINISH, "--record", kept.correction.record.id, serial="3611.154", status=3)


def touches_again(kept: JobInStore) -> None:
    kept.finish(kept.folder / "touches.csv", status=3)


def inches(kept: JobInStore) -> None:
    kept.finish(FINISH * 25.4, status=3)


def filled_in(kept: JobInStore) -> None:
    kept.finish(FINISH * 0.0, status=3)


def micrometres_as_millimetres(kept: JobInStore) -> None:
    kept.finish(FINISH * 1000.0, status=3)


def before_the_touches(kept: JobInStore) -> None:
    kept.finish(FINISH, "--measured-at", "2026-01-06T07:00", status=3)


def fewer_points(kept: JobInStore) -> None:
    kept.finish(FINISH[:12])


def in_another_order(kept: JobInStore) -> None:
    kept.finish(FINISH, "--order", 2, "--measured-at", "2026-01-06T12:00")
    kept.correct("3811.154", 1.5)
    kept.finish(FINISH * 1.1, "--order", 3, "--measured-at", "2026-01-06T10:00", serial="3811.154")


@pytest.mark.parametrize(
    ("misuse", "code"),
    [
        (other_part, "STO-OTHER-PART"),
        (of_no_correction, "STO-LINK"),
        (another_parts_record, "STO-LINK"),
        (touches_again, "STO-STAGE"),
        (inches, "STO-UNIT"),
        (filled_in, "STO-UNIT"),
        (micrometres_as_millimetres, "TCH-OFF-PROFILE"),
        (before_the_touches, "STO-CLOCK"),
        (fewer_points, "STO-PATTERN"),
        (in_another_order, "STO-ORDER"),
    ],
)
def test_misuse_is_refused_or_warned_of(kept: JobInStore, misuse: Callable[[JobInStore], None], code: str) -> None:
    misuse(kept)
    assert kept.said is not None and code in kept.said.stderr
    if kept.said.exit_code:
        finished = [one.value.part.serial for one in find(kept.store, Cut, stage=Stage.FINISH)]
        assert finished in ([], ["3511.158"]) and "hint:" in kept.said.stderr


def test_what_has_an_override_can_be_kept_all_the_same(kept: JobInStore) -> None:
    said = kept.finish(FINISH * 25.4, "--accept", "STO-UNIT")
    assert "warning STO-UNIT" in said.stderr and len(history_of(kept.store, EDGE)) == 1


def test_what_differs_needs_supersede(kept: JobInStore) -> None:
    kept.finish(FINISH, "--minutes", 3.2)
    assert "--supersede" in kept.finish(FINISH, "--minutes", 4.0, status=3).stderr
    kept.finish(FINISH, "--minutes", 4.0, "--supersede")
    (cut,) = (one.value for one in find(kept.store, Cut, stage=Stage.FINISH))
    assert cut.conditions.time_in_cut_min == 4.0 and len(find(kept.store, Cut, superseded=True)) == 3


def test_semifinish_touches_are_kept_before_the_correction_and_are_the_same_cut(tmp_path: Path) -> None:
    kept = job_in_store(tmp_path, correct=False)
    said = invoke(
        *("measure", "read", kept.folder / "touches.csv", "--job", kept.job, "--after", "semifinish"),
        *("--serial", "3511.158", "--measured-at", "2026-01-06T08:00"),
        status=0,
    )
    assert "1 part, 1 inspection, 1 cut" in said.stdout
    kept.correct("3511.158")
    assert len(find(kept.store, Cut)) == 1


def test_parts_whose_inspection_never_came_are_listed(kept: JobInStore) -> None:
    said = kept.correct("3611.154", 1.1)
    assert "note STO-OPEN" in said.stderr and "'3511.158'" in said.stderr
    kept.finish(FINISH)
    assert "'3511.158'" not in kept.correct("3711.162", 0.9).stderr


def test_usage(kept: JobInStore) -> None:
    file = kept.folder / "touches.csv"
    invoke("measure", "read", file, "--after", "finish", status=2)
    invoke("measure", "read", file, "--job", kept.job, "--order", 3, status=2)
    (kept.folder / "trueloop.db").unlink()
    assert "there is no store" in invoke("measure", "read", file, "-j", kept.job, "--after", "finish", status=2).stderr


def test_a_correction_was_not_in_force_in_the_cut_that_it_was_made_from(tmp_path: Path) -> None:
    """A part measured finished, corrected by it, cut again and measured again: a second cut, not the first one anew."""
    sizes = "a,seat-44,diameter,-105,44.0{0},44\nb,seat-36,diameter,-60,36.0{0},36\nc,seat-30,diameter,-20,30.0{0},30\n"
    head = "# serial: {}\n# measured_at: 2026-11-20 {}:00+01:00\ncharacteristic,feature,quantity,z_mm,actual,nominal\n"
    job = shaft_with(tmp_path, head.format("P1", "09") + sizes.format("30"))
    invoke("compensate", job, status=0)
    again = tmp_path / "again.csv"
    again.write_text(head.format("P1", "11") + sizes.format("02"))
    call = ("measure", "read", again, "--job", job, "--after", "finish", "--ran", "wear")
    said = invoke(*call, status=3).output
    assert "STO-LINK" in said and "was not in force in that cut" in said and "P1-2" in said
    assert "STO-LINK" in invoke(*call, "--supersede", status=3).output
    record = said.split("--record ")[1].split()[0]
    again.write_text(head.format("P1-2", "11") + sizes.format("02"))
    assert "1 inspection, 1 cut" in invoke(*call, "--record", record, status=0).output
