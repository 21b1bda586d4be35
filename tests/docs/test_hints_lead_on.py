"""What a hint names is done as it states, and the next call succeeds: no hint leads back to where it came from."""

import shlex
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.loops.test_cut_with import FIRST, SECOND, correct
from tests.support.cli import run
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.surface.job import read_surface
from trueloop.surface.compensation.program import corrected_program


def refusal_of(folder: Path, programs: str = "", more: str = "") -> TrueloopError:
    try:
        correct(folder, 2, SECOND, "contour", programs, more)
    except TrueloopError as refused:
        return refused
    raise AssertionError("it was not refused")


def test_measurements_from_before_the_record_are_stated_by_what_cut_them(tmp_path: Path) -> None:
    """MSR-OLD: leave out `gauging.after_record`, and state `programs.cut_with`."""
    correct(tmp_path, 1, FIRST, "contour")
    hour_ago = (datetime.now(UTC) - timedelta(hours=1)).isoformat()
    old = f"measured_at = {hour_ago}\n"
    refused = refusal_of(tmp_path, more=old + 'after_record = "o1/record.json"')
    assert refused.code is Code.MSR_OLD
    assert "leave out `gauging.after_record`" in refused.hint and "`programs.cut_with`" in refused.hint
    done = correct(tmp_path, 2, SECOND, "contour", 'cut_with = "given"', old)
    assert done.correction.record.cut_with is not None


def test_what_cut_a_part_is_stated_by_a_key_of_the_hint(tmp_path: Path) -> None:
    """CMP-CUT-WITH: both answers that it names are taken."""
    correct(tmp_path, 1, FIRST, "contour")
    refused = refusal_of(tmp_path)
    assert refused.code is Code.CMP_CUT_WITH and 'programs.cut_with = "given"' in refused.hint
    for answer in ("given", "o1/record.json"):
        correct(tmp_path, 2, SECOND, "contour", f'cut_with = "{answer}"')


def test_too_few_parts_of_a_surface_come_together_in_a_store(tmp_path: Path) -> None:
    """SRF-PARTS: `trueloop surface add` keeps each part, and the pattern is made of all."""
    run("examples", "surface", "-o", tmp_path)
    job = next(tmp_path.glob("**/surface.toml"))
    text = job.read_text().replace('"best-fit"', '"datum"')  # one part does for form alone
    parts = sorted((job.parent / "parts").glob("*.csv"))[:3]
    for part in parts:
        job.write_text(text.replace('"parts/*.csv"', f'"parts/{part.name}"'))
        if part is parts[0]:  # the others are not in the store yet
            refused = run("surface", "pattern", job, "-o", tmp_path / "out", status=3)
            assert "SRF-PARTS" in refused and "`trueloop surface add`" in refused
        run("surface", "add", job)
    run("surface", "pattern", job, "-o", tmp_path / "out")


def test_a_store_that_is_not_there_is_made_by_the_command_of_the_hint(tmp_path: Path) -> None:
    """STO-FILE: `trueloop db init` with the name that the command was given, not with that of every store."""
    place = tmp_path / "the shop's.db"
    refused = run("db", "check", "--db", place, status=3)
    run(*shlex.split(refused.partition("make it by `trueloop ")[2].partition("`,")[0]))
    run("db", "check", "--db", place)


def test_a_code_of_a_surface_s_program_that_is_unknown_is_accepted_by_the_key_of_its_hint(tmp_path: Path) -> None:
    """NC-CODE: jobs of surfaces have a table `[program]`, no `[programs]`."""
    run("examples", "surface", "-o", tmp_path)
    job = next(tmp_path.glob("**/surface.toml"))
    job.write_text(job.read_text().replace("[program]\n", '[program]\ndialect = "linuxcnc"\n'))
    program = job.parent / "finish.ngc"
    program.write_text(program.read_text().replace("G21", "G21 G68", 1), "utf-8")

    def corrected() -> bytes:
        given = read_surface(job).inputs
        assert given.program is not None and given.cutter is not None
        return corrected_program(given.program, given.surface, given.surface, given.cutter, "0123456789abcdef").source

    with pytest.raises(TrueloopError) as refused:
        corrected()
    assert refused.value.code is Code.NC_CODE and refused.value.override == "program.accept_unknown_words in the job"
    job.write_text(job.read_text().replace("[program]\n", "[program]\naccept_unknown_words = true\n"))
    assert b"G21 G68" in corrected()
