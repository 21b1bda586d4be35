"""Writing a set of files: all of it or none.

Every file is written and synced beside its destination first, and a copy of what it will replace is kept; then the
files are renamed into place in the order given. Guaranteed: no file is ever seen half written; after any error, or an
interrupt by the user, the folder holds what it held before. Not guaranteed: a power failure or `kill -9` within the
renames (well under a millisecond) can leave the first files new and the rest old, each of them whole, and a folder
`.trueloop-*` with the old ones.
"""

import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from trueloop.errors import Code, Place, TrueloopError


def write_all(folder: Path, contents: Mapping[str, bytes], inputs: Iterable[Path] = ()) -> list[Path]:
    """Writes `contents` (file name → bytes) into `folder`, made if missing, and returns the paths in their order.

    Raises OUT-INPUT when a file to be written is one of `inputs`, and OUT-FOLDER when the system refuses; in both
    cases nothing is written, and a folder made for it is removed again.
    """
    _require_no_input(folder, contents, inputs)
    made: list[Path] = []
    try:
        _make(folder, made)
        _write(folder, contents)
    except BaseException as error:
        for path in reversed(made):
            path.rmdir()
        if isinstance(error, OSError):
            raise _refusal(folder, contents, error) from error
        raise
    return [folder / name for name in contents]


@contextmanager
def written_as_it_comes(path: Path, inputs: Iterable[Path] = ()) -> Iterator[BinaryIO]:
    """A file for what is too large to be held: written beside `path`, synced and renamed to it at the end.

    After any error there is what was there before. Raises OUT-INPUT and OUT-FOLDER as `write_all`.
    """
    _require_no_input(path.parent, {path.name: b""}, inputs)
    made: list[Path] = []
    part: Path | None = None
    try:
        _make(path.parent, made)
        handle, name = tempfile.mkstemp(prefix=".trueloop-", dir=path.parent)
        part = Path(name)
        with os.fdopen(handle, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        part.chmod(0o666 & ~_umask())
        part.replace(path)
        _sync(path.parent)
    except BaseException as error:
        if part is not None:
            part.unlink(missing_ok=True)
        for folder in reversed(made):
            folder.rmdir()
        if isinstance(error, OSError):
            raise _refusal(path.parent, {}, error) from error
        raise


def _umask() -> int:
    """The process's mask; there is no way to read it but to set it."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _require_no_input(folder: Path, contents: Mapping[str, bytes], inputs: Iterable[Path]) -> None:
    resolved = {path.resolve(): path for path in inputs}
    for name in contents:
        if (source := resolved.get((folder / name).resolve())) is not None:
            raise TrueloopError(
                Code.OUT_INPUT,
                f"{name!r} ({len(contents[name])} bytes) would overwrite the input {str(source)!r}",
                hint="write to another folder: `--output`, or `output.folder` in the job",
                place=Place(str(folder / name)),
            )


def _make(folder: Path, made: list[Path]) -> None:
    """`mkdir -p` that notes what it made."""
    if not folder.exists():
        _make(folder.parent, made)
        folder.mkdir()
        made.append(folder)


def _write(folder: Path, contents: Mapping[str, bytes]) -> None:
    staging = Path(tempfile.mkdtemp(prefix=".trueloop-", dir=folder))
    try:
        for name, content in contents.items():
            _write_synced(staging / f"{name}.new", content)
            if (folder / name).exists():
                shutil.copy2(folder / name, staging / f"{name}.old")
        try:
            for name in contents:
                (staging / f"{name}.new").replace(folder / name)
        except BaseException:
            _put_back(folder, staging, contents)
            raise
        _sync(folder)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _put_back(folder: Path, staging: Path, contents: Mapping[str, bytes]) -> None:
    """Undoes the renames that happened: those whose new file has left the staging folder."""
    for name in contents:
        if (staging / f"{name}.new").exists():
            continue
        if (staging / f"{name}.old").exists():
            (staging / f"{name}.old").replace(folder / name)
        else:
            (folder / name).unlink()


def _write_synced(path: Path, content: bytes) -> None:
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _sync(folder: Path) -> None:
    """Makes the renames outlast a power failure, where the file system can sync a folder."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _refusal(folder: Path, contents: Mapping[str, bytes], error: OSError) -> TrueloopError:
    needed = sum(map(len, contents.values()))
    return TrueloopError(
        Code.OUT_FOLDER,
        f"nothing was written to {str(folder)!r}: {error.strerror or error}; {needed} bytes were needed, "
        f"{_free_bytes(folder)} are free",
        hint="name a folder you may write to, on a disk with room: `--output`, or `output.folder` in the job",
        place=Place(str(folder)),
    )


def _free_bytes(folder: Path) -> str:
    """Free space where the folder is or would be made."""
    for path in (folder, *folder.absolute().parents):
        with suppress(OSError):
            return str(shutil.disk_usage(path).free)
    return "an unknown number"
