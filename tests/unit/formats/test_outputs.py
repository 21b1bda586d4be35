"""All files or none, whatever goes wrong on the way."""

import os
import resource
import subprocess
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import pytest

from tests.support.refusals import refused
from trueloop.errors import Code, TrueloopError
from trueloop.formats.outputs import write_all, written_as_it_comes

OLD = {"corrected.nc": b"old program\n", "table.csv": b"old table\n"}
NEW = {"corrected.nc": b"new program\n", "table.csv": b"new table\n", "record.json": b"{}\n"}


def _holds(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def _fill(folder: Path) -> None:
    for name, content in OLD.items():
        (folder / name).write_bytes(content)


def _refused(folder: Path, inputs: Sequence[Path] = ()) -> TrueloopError:
    return refused(write_all, folder, NEW.items(), inputs)


def test_a_missing_folder_is_made_and_the_paths_come_back_in_order(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    assert write_all(folder, NEW.items()) == [folder / name for name in NEW]
    assert _holds(folder) == NEW


def test_old_files_of_the_set_are_replaced_and_others_left(tmp_path: Path) -> None:
    _fill(tmp_path)
    (tmp_path / "notes.txt").write_bytes(b"mine")
    write_all(tmp_path, NEW.items())
    assert _holds(tmp_path) == NEW | {"notes.txt": b"mine"}


def test_a_file_that_is_no_part_of_the_set_any_more_is_taken_away(tmp_path: Path) -> None:
    _fill(tmp_path)
    written = write_all(tmp_path, [("corrected.nc", b"new"), ("table.csv", None), ("other", None)])
    assert written == [tmp_path / "corrected.nc"]
    assert _holds(tmp_path) == {"corrected.nc": b"new"}


@pytest.mark.parametrize("renamed_first", [False, True], ids=["before the rename", "after the rename"])
@pytest.mark.parametrize("failing", range(len(NEW)))
@pytest.mark.parametrize("error", [OSError(5, "Input/output error"), KeyboardInterrupt()], ids=["disk", "Ctrl-C"])
def test_a_failure_at_any_rename_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: int, renamed_first: bool, error: BaseException
) -> None:
    _fill(tmp_path)
    (tmp_path / "stale.nc").write_bytes(b"of an earlier run\n")
    rename, count = Path.replace, 0

    def failing_rename(self: Path, target: Path) -> Path:
        nonlocal count
        count += 1
        if count == failing + 1:
            if renamed_first:
                rename(self, target)
            raise error
        return rename(self, target)

    monkeypatch.setattr(Path, "replace", failing_rename)
    with pytest.raises(TrueloopError if isinstance(error, OSError) else KeyboardInterrupt):
        write_all(tmp_path, [("stale.nc", None), ("none.nc", None), *NEW.items()])
    assert count > failing
    assert _holds(tmp_path) == OLD | {"stale.nc": b"of an earlier run\n"}


def test_content_may_be_made_when_its_turn_has_come_and_all_or_none_is_written_still(tmp_path: Path) -> None:
    turns = iter([b"first", b"second"])
    write_all(tmp_path / "out", [("a.csv", lambda: next(turns)), ("b.csv", b"held"), ("c.csv", lambda: next(turns))])
    assert _holds(tmp_path / "out") == {"a.csv": b"first", "b.csv": b"held", "c.csv": b"second"}

    def refused() -> bytes:
        raise ConnectionError("the worker is gone")

    with pytest.raises(ConnectionError):  # not told as a failure to write
        write_all(tmp_path / "none", [("a.csv", lambda: b"first"), ("b.csv", refused)])
    assert not (tmp_path / "none").exists()


def test_a_disk_without_room_leaves_what_was_there_and_no_new_folder(tmp_path: Path) -> None:
    """The system itself refuses: a limit on the size of files stands for the full disk, for any user, everywhere."""
    _fill(tmp_path)
    program = (
        "import sys\nfrom pathlib import Path\nfrom trueloop.formats.outputs import write_all\n"
        "contents = [('a.nc', b'x' * 1000), ('b.nc', b'x' * 100_000)]\n"
        "write_all(Path(sys.argv[1]), contents)"
    )
    for folder in (tmp_path, tmp_path / "new" / "folder"):
        run = subprocess.run(
            [sys.executable, "-c", program, str(folder)],
            capture_output=True,
            text=True,
            check=False,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000)),
        )
        assert run.returncode == 1
        assert "OUT-FOLDER" in run.stderr
        assert "File too large; 101000 bytes were needed" in run.stderr
        assert _holds(tmp_path) == OLD


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").write_bytes(b"a file")
    for folder in (tmp_path / "out", tmp_path / "out" / "deeper"):
        refusal = _refused(folder)
        assert refusal.code is Code.OUT_FOLDER
        assert "Not a directory" in refusal.message
    assert _holds(tmp_path) == {"out": b"a file"}


def test_a_folder_in_place_of_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "record.json").mkdir()
    assert _refused(tmp_path).code is Code.OUT_FOLDER
    assert [path.name for path in tmp_path.iterdir()] == ["record.json"]


@pytest.mark.parametrize("folder", ["/proc/trueloop", "/sys/trueloop/out"])
def test_a_folder_that_not_even_root_may_make_is_refused(folder: str) -> None:
    refusal = _refused(Path(folder))
    assert refusal.code is Code.OUT_FOLDER
    assert str(refusal.place) == folder
    assert f"{sum(map(len, NEW.values()))} bytes" in refusal.message


def test_an_input_is_never_overwritten_by_whatever_name(tmp_path: Path) -> None:
    _fill(tmp_path)
    (tmp_path / "link").symlink_to(tmp_path)
    (tmp_path / "alias.nc").symlink_to("corrected.nc")
    for source in (tmp_path / "corrected.nc", tmp_path / "link" / "corrected.nc", tmp_path / "alias.nc"):
        refusal = _refused(tmp_path, inputs=[source])
        assert refusal.code is Code.OUT_INPUT
        assert str(source) in refusal.message
    assert (tmp_path / "corrected.nc").read_bytes() == OLD["corrected.nc"]


def test_two_files_of_one_name_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    refusal = refused(write_all, tmp_path / "out", [*NEW.items(), ("table.csv", b"another\n")])
    assert refusal.code is Code.OUT_TWICE
    assert "2 of 4 files" in refusal.message and "'table.csv'" in refusal.message
    assert _holds(tmp_path) == {}


def test_pieces_are_written_as_they_come_and_become_the_file_at_the_end(tmp_path: Path) -> None:
    _fill(tmp_path)
    with written_as_it_comes(tmp_path / "corrected.nc") as out:
        out.write(b"new ")
        out.writelines([b"pro", b"gram\n"])
        assert (tmp_path / "corrected.nc").read_bytes() == OLD["corrected.nc"]
    assert _holds(tmp_path) == OLD | {"corrected.nc": NEW["corrected.nc"]}


@pytest.mark.parametrize("error", [OSError(5, "Input/output error"), KeyboardInterrupt()], ids=["reading", "Ctrl-C"])
def test_what_fails_while_the_pieces_are_made_is_no_failure_to_write(tmp_path: Path, error: BaseException) -> None:
    """The program that is read may lie on a disk that fails: that is not said of the folder written to."""
    _fill(tmp_path)

    def pieces() -> Iterator[bytes]:
        yield b"new"
        raise error

    for folder in (tmp_path, tmp_path / "new"):
        with pytest.raises(type(error)) as told, written_as_it_comes(folder / "corrected.nc") as out:
            out.writelines(pieces())
        assert told.value is error
        assert _holds(tmp_path) == OLD


@pytest.mark.parametrize("name", ["folder", "pipe", ""])
def test_what_is_no_file_is_never_replaced(tmp_path: Path, name: str) -> None:
    """A rename would put the file in the place of /dev/null, where the user may."""
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")

    def streamed() -> None:
        with written_as_it_comes(tmp_path / name) as out:
            out.write(b"x")

    for write in (partial(write_all, tmp_path, [(name, b"x")]), streamed):
        refusal = refused(write)
        assert refusal.code is Code.OUT_FOLDER and "is no file" in refusal.message
        assert refusal.place.file == str(tmp_path / name)
    assert (tmp_path / "pipe").is_fifo() and sorted(path.name for path in tmp_path.iterdir()) == ["folder", "pipe"]


def test_a_full_disk_met_by_a_piece_or_at_the_end_leaves_what_was_there(tmp_path: Path) -> None:
    """Small pieces wait in a buffer: the system refuses them at the end, and again as the file is closed."""
    program = (
        "import sys\nfrom pathlib import Path\nfrom trueloop.formats.outputs import written_as_it_comes\n"
        "with written_as_it_comes(Path(sys.argv[1]) / 'a.nc') as out:\n"
        "    out.write(b'x' * int(sys.argv[2]))"
    )
    for size in ("3000", "100000"):
        run = subprocess.run(
            [sys.executable, "-c", program, str(tmp_path / "new"), size],
            capture_output=True,
            text=True,
            check=False,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, 2_000)),
        )
        assert run.returncode == 1
        assert run.stderr.splitlines()[-2].startswith("trueloop.errors.TrueloopError: "), run.stderr
        assert "OUT-FOLDER" in run.stderr and "File too large" in run.stderr
        assert _holds(tmp_path) == {}
