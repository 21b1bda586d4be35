"""Commands that keep what they find, where the disk is full: refused, nothing half kept, no output written."""

import resource
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.support.cli import invoke
from tests.support.job_in_store import FINISH, SERIAL, JobInStore, job_in_store
from trueloop.cli.terminal import ExitStatus
from trueloop.storage.integrity import damage
from trueloop.storage.kinds import KINDS
from trueloop.storage.store import find

ROOM_BYTES = 33_000
"""No file grows beyond it: SQLite's index of its log does not, the log itself would."""
LONGEST_S = 300


def _full() -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM_BYTES, ROOM_BYTES))


def refused_on_a_full_disk(arguments: Sequence[object]) -> str:
    """What a command says where files cannot grow."""
    program = Path(sys.executable).with_name("trueloop")
    done = subprocess.run(
        [program, *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
        preexec_fn=_full,
        check=False,
    )
    assert done.returncode == ExitStatus.REFUSED, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done.stderr


def rows(kept: JobInStore) -> dict[str, int]:
    return {kind.table: len(find(kept.store, kind.type)) for kind in KINDS}


def files(kept: JobInStore) -> set[str]:
    return {str(path.relative_to(kept.folder)) for path in kept.folder.rglob("*") if ".db-" not in path.name}


def test_a_correction_is_kept_whole_or_not_at_all(tmp_path: Path) -> None:
    kept = job_in_store(tmp_path, correct=False)
    before = files(kept)
    command = ("compensate", kept.job, "--serial", SERIAL, "--db", tmp_path / "trueloop.db")
    said = refused_on_a_full_disk(command)
    assert "STO-WRITE" in said and "nothing was kept" in said
    assert files(kept) == before and not any(rows(kept).values())
    assert damage(kept.store) == []
    invoke(*command, status=0)
    assert rows(kept)["correction"] == 1 and (tmp_path / "out" / "corrected.nc").is_file()


def test_an_inspection_is_kept_with_its_cut_and_link_or_not_at_all(tmp_path: Path) -> None:
    kept = job_in_store(tmp_path)
    head, *lines = kept.rows
    found = [f"{','.join(line.split(',')[:-1])},{um:.6f}" for line, um in zip(lines, FINISH, strict=False)]
    (tmp_path / "after.csv").write_text("\n".join([head, *found, ""]), encoding="utf-8")
    before, known = files(kept), rows(kept)
    command = ("measure", "read", tmp_path / "after.csv", "--job", kept.job, "--after", "finish", "--serial", SERIAL)
    given = (*command, "--db", tmp_path / "trueloop.db", "-o", tmp_path / "read.csv")
    said = refused_on_a_full_disk(given)
    assert "STO-WRITE" in said and "nothing was kept" in said
    assert files(kept) == before and rows(kept) == known
    assert damage(kept.store) == []
    invoke(*given, status=0)
    assert rows(kept)["inspection_link"] == known["inspection_link"] + 1
    assert files(kept) > before
