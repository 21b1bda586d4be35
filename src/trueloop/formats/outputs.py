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
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, TypeAlias

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import FilePath

Named: TypeAlias = tuple[str, bytes | Callable[[], bytes] | None]
"""A file's name and content, or what makes it in its turn. None: there shall be no such file."""


def write_all(folder: FilePath, contents: Iterable[Named], inputs: Iterable[Path] = ()) -> list[Path]:
    """Writes files of these names into `folder`, made if missing, and returns the paths in their order.

    Raises OUT-INPUT when a file to be written is one of `inputs`, OUT-TWICE when two have one name, and OUT-FOLDER when
    the system refuses; then nothing is written, and a folder made for it is removed again.

    >>> files = trueloop.write_all("out", [("a.txt", b"first"), ("b.txt", b"second")])
    >>> [file.name for file in files]
    ['a.txt', 'b.txt']
    """
    folder = Path(folder)
    files = list(contents)
    _require_different(folder, [name for name, _ in files], inputs)
    held = [len(content or b"") for _, content in files if not callable(content)]
    needed = sum(held) if len(held) == len(files) else None
    with _folder_made(folder, needed):
        _write(folder, files, needed)
    return [folder / name for name, content in files if content is not None]


class Output:
    """A file that is being written. Raises OUT-FOLDER when the system refuses to write, and lets through all else."""

    def __init__(self, file: BinaryIO, folder: Path) -> None:
        self._file, self._folder = file, folder

    def write(self, piece: bytes) -> None:
        """Adds a piece."""
        with _refusing(self._folder):
            self._file.write(piece)

    def writelines(self, pieces: Iterable[bytes]) -> None:
        """Adds pieces as they come."""
        for piece in pieces:
            self.write(piece)


@contextmanager
def written_as_it_comes(path: Path, inputs: Iterable[Path] = ()) -> Iterator[Output]:
    """Opens a file for output beside `path`, renamed to it when whole. Raises OUT-INPUT and OUT-FOLDER."""
    folder = path.parent
    _require_different(folder, [path.name], inputs)
    with _folder_made(folder):
        with _refusing(folder):
            handle, name = tempfile.mkstemp(prefix=".trueloop-", dir=folder)
        part, file = Path(name), os.fdopen(handle, "wb")
        try:
            yield Output(file, folder)
            with _refusing(folder):
                file.flush()
                os.fsync(file.fileno())
                file.close()
                part.chmod(0o666 & ~_umask())
                part.replace(path)
                _sync(folder)
        except BaseException:
            with suppress(OSError):  # writes what is still held, once more: the first error is the one to tell
                file.close()
            part.unlink(missing_ok=True)
            raise


@contextmanager
def _folder_made(folder: Path, needed: int | None = None) -> Iterator[None]:
    """The folder is there; after any error it is as it was."""
    made: list[Path] = []
    try:
        with _refusing(folder, needed):
            _make(folder, made)
        yield
    except BaseException:
        for path in reversed(made):
            with suppress(OSError):  # others may have put something there meanwhile
                path.rmdir()
        raise


@contextmanager
def _refusing(folder: Path, needed: int | None = None) -> Iterator[None]:
    """Describes the refusal of the operating system."""
    try:
        yield
    except OSError as error:
        raise _refusal(folder, needed, error) from error


def _umask() -> int:
    """The process's mask; there is no way to read it but to set it."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _require_different(folder: Path, names: Sequence[str], inputs: Iterable[Path]) -> None:
    """No file to be written is another one, nor one that was read, nor in the place of what is not a file."""
    resolved = {path.resolve(): path for path in inputs}
    for name in names:
        if names.count(name) > 1:
            raise Code.OUT_TWICE.refusal(
                f"{names.count(name)} of {len(names)} files to be written have the name {name!r}",
                hint="name the output otherwise",
                place=Place(str(folder / name)),
                values={"file": name},
            )
        if (source := resolved.get((folder / name).resolve())) is not None:
            raise Code.OUT_INPUT.refusal(
                f"{name!r} would overwrite the input {str(source)!r}",
                hint="write elsewhere: `--output` or `--out`, or `output.folder` in the job",
                place=Place(str(folder / name)),
                values={"file": name, "input": str(source)},
            )
        # A rename would put the file in the place of a device, where the user may do so.
        if (folder / name).exists() and not (folder / name).is_file():
            raise Code.OUT_FOLDER.refusal(
                f"nothing was written: what {str(folder / name)!r} names is there and is no file",
                hint="name a file that is new, or to be replaced",
                place=Place(str(folder / name)),
            )


def _make(folder: Path, made: list[Path]) -> None:
    """`mkdir -p` that notes what it made."""
    if not folder.exists():
        _make(folder.parent, made)
        folder.mkdir()
        made.append(folder)


def _write(folder: Path, files: Sequence[Named], needed: int | None) -> None:
    """Writes the files; an error while making a content is not a failure to write."""
    with _refusing(folder, needed):
        staging = Path(tempfile.mkdtemp(prefix=".trueloop-", dir=folder))
    try:
        for name, content in files:
            made = content() if callable(content) else content
            with _refusing(folder, needed):
                if made is not None:
                    with (staging / f"{name}.new").open("wb") as file:
                        file.write(made)
                        file.flush()
                        os.fsync(file.fileno())
                if (folder / name).exists():
                    shutil.copy2(folder / name, staging / f"{name}.old")
        with _refusing(folder, needed):
            _rename(folder, staging, [name for name, _ in files])
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _rename(folder: Path, staging: Path, names: Sequence[str]) -> None:
    try:
        for name in names:
            if (staging / f"{name}.new").exists():
                (staging / f"{name}.new").replace(folder / name)
            else:
                (folder / name).unlink(missing_ok=True)
    except BaseException:
        _put_back(folder, staging, names)
        raise
    _sync(folder)


def _put_back(folder: Path, staging: Path, names: Iterable[str]) -> None:
    """Undoes the renames that happened: those whose new file has left the staging folder."""
    for name in names:
        if (staging / f"{name}.new").exists():
            continue
        if (staging / f"{name}.old").exists():
            (staging / f"{name}.old").replace(folder / name)
        else:
            (folder / name).unlink(missing_ok=True)


def _sync(folder: Path) -> None:
    """Makes the renames outlast a power failure, where the file system can sync a folder."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _refusal(folder: Path, needed: int | None, error: OSError) -> TrueloopError:
    wanted = "" if needed is None else f"{needed} bytes were needed, "
    return Code.OUT_FOLDER.refusal(
        f"nothing was written to {str(folder)!r}: {error.strerror or error}; {wanted}{_free_bytes(folder)} are free",
        hint="name a folder that takes it, on a disk with room: `--output` or `--out`, or `output.folder` in the job",
        place=Place(str(folder)),
    )


def _free_bytes(folder: Path) -> str:
    """Free space where the folder is or would be made."""
    for path in (folder, *folder.absolute().parents):
        with suppress(OSError):
            return f"{shutil.disk_usage(path).free} bytes"
    return "an unknown number"
