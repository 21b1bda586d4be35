"""samples.csv: a row for every servo period of a run. docs/realtime-samples.md describes the columns.

Written by whole lines, so that a record is whole up to its last line whenever the recorder ends. The reader leaves out
a last line without an end: only a process killed in the middle of a write leaves one.

The log of signals: `time_s` (s since 1970), T1_degC, spindle_rpm …, a row a second, as `read_history` reads it.

The file by itself always reaches back as far as lags need: when it is full it is begun anew with its last rows, and
what it held before is kept beside it.
"""

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import FilePath, read_text
from trueloop.formats.measurements.history_csv import read_history
from trueloop.formats.outputs import write_all
from trueloop.machine.model.history import History
from trueloop.realtime.samples import AXES, COUNTS, TIMES_NS, Samples, column_names

BLOCK: Final = 1000
"""Rows that are made into text at once."""
WHOLE: Final = (*COUNTS, *TIMES_NS)
OFF: Final = 1e-6
"""The share of a period by which a time may be off a whole number of them, with nine decimals of a second."""
DECIMALS_S: Final = 1e-9
HINT: Final = "name a samples.csv as `trueloop realtime watch` writes it; docs/realtime-samples.md has the columns"


def header(axes: str, signals: Sequence[str]) -> bytes:
    """Returns the heading line."""
    return (",".join(column_names(axes, signals)) + "\n").encode()


def lines(samples: Samples) -> Iterator[bytes]:
    """Yields the rows as whole lines, many at once."""
    names = column_names(samples.axes, samples.signals)
    table = np.column_stack([samples.columns[name] for name in names])
    line = ",".join(map(_form, names)) + "\n"
    for start in range(0, len(table), BLOCK):
        rows = table[start : start + BLOCK]
        yield (line * len(rows) % tuple(rows.ravel().tolist())).encode()


def samples_csv(samples: Samples) -> bytes:
    """Returns the whole file.

    >>> from trueloop.realtime.samples import Samples, column_names
    >>> names = column_names("x", ["T1_degC"])
    >>> one = Samples(1e-3, "x", ("T1_degC",), {name: np.zeros(1) for name in names})
    >>> samples_csv(one).decode().split()[1].split(",")[:5]
    ['0.000000000', '0.000000000', '0.000000000', '0.000000000', '0.000000']
    """
    return header(samples.axes, samples.signals) + b"".join(lines(samples))


def _form(name: str) -> str:
    """A nanometre counts: lengths in mm have nine decimals, in µm six."""
    if name in WHOLE:
        return "%d"
    return "%.9f" if name == "time_s" or name.endswith("_mm") else "%.6f"


def read_samples(path: FilePath) -> Samples:
    """Reads a record. Raises RTC-SAMPLES with file, line and column for what is none."""
    path = Path(path)
    text = read_text(path, Code.RTC_SAMPLES, hint=HINT)
    head, _, body = text.partition("\n")
    names = head.rstrip("\r").split(",")
    axes, signals = _of_header(names, path)
    body = body[: body.rfind("\n") + 1]
    table = _numbers(body, names, path)
    columns = {name: table[:, names.index(name)].copy() for name in column_names(axes, signals)}
    _require_whole(columns, names, path)
    return Samples(_period_s(columns["time_s"], path), axes, signals, columns)


def _of_header(names: Sequence[str], path: Path) -> tuple[str, tuple[str, ...]]:
    """Axes and signals. What is neither of the record's own columns nor a second one is a signal."""
    axes = "".join(axis for axis in AXES if f"command_{axis}_mm" in names)
    own = set(column_names(axes, ()))
    missing = sorted(own - set(names))
    if missing or not axes:
        what = f"columns {', '.join(missing[:4])}" if axes else "columns command_x_mm or the like"
        raise _refusal(path, 1, None, f"{what} are missing among {len(names)}")
    twice = next((name for k, name in enumerate(names) if name in names[:k] or not name), None)
    if twice is not None:
        place = len(names) - names[::-1].index(twice)
        raise _refusal(path, 1, place, f"column {place}, {twice!r}, has no name or one that was there before")
    of_other_axes = set(column_names(AXES, ())) - own
    stray = next((name for name in names if name in of_other_axes), None)
    if stray is not None:
        place = names.index(stray) + 1
        raise _refusal(path, 1, place, f"column {place}, {stray!r}, is of an axis without command")
    return axes, tuple(name for name in names if name not in own)


def _numbers(body: str, names: Sequence[str], path: Path) -> Array:
    rows = body.splitlines()
    if len(rows) < 2:
        raise _refusal(path, 1 + len(rows), None, f"{len(rows)} periods; two are the least")
    try:
        table = np.loadtxt(rows, delimiter=",", ndmin=2, comments=None)
    except ValueError as error:
        raise _first_wrong(rows, names, path) from error
    if len(table) != len(rows) or table.shape[1] != len(names):  # an empty line, or fewer cells everywhere
        raise _first_wrong(rows, names, path)
    return table


def _first_wrong(rows: Sequence[str], names: Sequence[str], path: Path) -> TrueloopError:
    """Where a table is none."""
    for number, row in enumerate(rows, 2):
        cells = row.split(",")
        if len(cells) != len(names):
            return _refusal(path, number, None, f"{len(cells)} values where the header names {len(names)}")
        for place, cell in enumerate(cells, 1):
            if not _is_number(cell):
                return _refusal(path, number, place, f"{cell!r} in column {place}, {names[place - 1]}, is no number")
    return _refusal(path, 2, None, f"the {len(rows)} rows are no table of numbers")


def _is_number(cell: str) -> bool:
    """As NumPy reads it: without the underscores that Python allows."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _require_whole(columns: dict[str, Array], names: Sequence[str], path: Path) -> None:
    for name in ("time_s", *WHOLE):
        column = columns[name]
        wrong = ~np.isfinite(column) if name == "time_s" else column != np.trunc(column)
        wrong |= ~np.isfinite(column)
        if wrong.any():
            row = int(np.argmax(wrong))
            kind = "finite" if name == "time_s" else "whole"
            raise _refusal(path, row + 2, names.index(name) + 1, f"{name} is {column[row]:g}, no {kind} number")


def _period_s(time_s: Array, path: Path) -> float:
    """The shortest step in time; all others are whole numbers of it. Between two periods stand those that were lost."""
    steps = np.diff(time_s)
    if steps.min() <= 0.0:
        row = int(np.argmax(steps <= 0.0)) + 1
        raise _refusal(path, row + 2, None, f"time goes from {time_s[row - 1]:.9f} s to {time_s[row]:.9f} s")
    count = np.round(steps / steps.min())
    period_s = float(np.median(steps / count))
    off = np.abs(steps - count * period_s)
    if (wrong := off > OFF * period_s * count + 2 * DECIMALS_S).any():
        row = int(np.argmax(wrong)) + 1
        whole = f"no whole number of periods of {period_s:.9f} s"
        raise _refusal(path, row + 2, None, f"{steps[row - 1]:.9f} s after the period before it: {whole}")
    return float(steps.sum() / count.sum())


def _refusal(path: Path, line: int, column: int | None, message: str) -> TrueloopError:
    return Code.RTC_SAMPLES.refusal(message, hint=HINT, place=Place(str(path), line, column))


class Recording:
    """A record that grows while it is made: samples.csv, then samples-2.csv, … of so many rows each, by whole lines.

    Of many files the last `keep` stay. Raises OUT-FOLDER where there is a record already, or the system refuses.
    """

    def __init__(
        self, folder: Path, axes: str, signals: Sequence[str], most_rows: int, keep: int | None = None
    ) -> None:
        self.files: list[Path] = []
        self._folder, self._header, self._most, self._keep = folder, header(axes, signals), most_rows, keep
        with _writable(folder):
            folder.mkdir(parents=True, exist_ok=True)
        self._begin()

    def add(self, samples: Samples) -> None:
        """Appends periods."""
        while len(samples):
            if self._rows == self._most:
                self._file.close()
                self._begin()
            fitting = min(len(samples), self._most - self._rows)
            for piece in lines(samples.rows(slice(0, fitting))):
                with _writable(self._folder):
                    self._file.write(piece)
            self._rows += fitting
            samples = samples.rows(slice(fitting, None))

    def close(self) -> None:
        """Writes what is pending and closes the file."""
        self._file.close()

    def _begin(self) -> None:
        number = len(self.files) + 1
        self.files.append(self._folder / ("samples.csv" if number == 1 else f"samples-{number}.csv"))
        with _writable(self._folder):
            self._file = self.files[-1].open("xb", buffering=0)
            self._file.write(self._header)
            if self._keep is not None and number > self._keep:
                self.files[number - 1 - self._keep].unlink(missing_ok=True)
        self._rows = 0


@contextmanager
def _writable(folder: Path) -> Iterator[None]:
    try:
        yield
    except FileExistsError as error:
        raise Code.OUT_FOLDER.refusal(
            f"nothing was written to {str(folder)!r}: {Path(error.filename).name!r} is there already, and a record is "
            "never written over",
            hint="name another folder: `--out`",
            place=Place(str(folder)),
        ) from error
    except OSError as error:
        raise Code.OUT_FOLDER.refusal(
            f"{str(folder)!r} takes no more: {error.strerror or error}",
            hint="name a folder that can be written to, on a disk with room: `--out`",
            place=Place(str(folder)),
        ) from error


KEPT: Final = 7
"""Earlier files beside the log."""


@dataclass
class SignalLog:
    """A log that is being written. `keep_s`: how far back it reaches at least, once so much was recorded."""

    path: Path
    columns: tuple[str, ...]
    keep_s: float
    most_rows: int
    rows: int = 0
    last_s: float = -np.inf

    def recorded(self, now_s: float) -> History | None:
        """Returns the readings recorded before; None: no log of these signals that can be continued."""
        with suppress(OSError, TrueloopError):
            with self.path.open("rb") as file:
                head = file.readline().strip()
            history = read_history(self.path) if head == self._head().encode() else None
            if history is not None and len(history.time_s) and history.time_s[-1] < now_s:
                return history
        return None

    def begin(self, now_s: float) -> History | None:
        """Opens the log to continue it; one that cannot be continued is kept aside. Raises `OSError`, OUT-FOLDER."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        if self.path.exists():
            self._drop_half_a_line()
        history = self.recorded(now_s)
        if history is not None:
            self.rows, self.last_s = len(history.time_s), float(history.time_s[-1])
            return history
        if self.path.exists():
            self._keep()
        self._write([])
        return None

    def append(self, time_s: float, values: Sequence[float]) -> None:
        """Appends a row. A time that is not later is left out. Raises `OSError`."""
        if time_s <= self.last_s:
            return
        if self.rows >= self.most_rows:
            self._begin_anew(time_s)
        with self.path.open("a", encoding="ascii", newline="\n") as file:
            file.write(",".join([f"{time_s:.3f}", *(f"{value:.4f}" for value in values)]) + "\n")
        self.rows, self.last_s = self.rows + 1, time_s

    def _begin_anew(self, now_s: float) -> None:
        lines = self.path.read_text(encoding="ascii").splitlines()[1:]
        last = [line for line in lines if float(line.partition(",")[0]) >= now_s - self.keep_s]
        self._keep()
        self._write(last)

    def _head(self) -> str:
        return ",".join(["time_s", *self.columns])

    def _write(self, lines: list[str]) -> None:
        write_all(self.path.parent, [(self.path.name, "\n".join([self._head(), *lines, ""]).encode("ascii"))])
        self.rows = len(lines)

    def _drop_half_a_line(self) -> None:
        """Of a row that a power failure cut off."""
        content = self.path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if whole != content and whole.startswith(self._head().encode()):
            self.path.write_bytes(whole)

    def _keep(self) -> None:
        """The log as it is becomes number 1, number 1 becomes 2, … and the last is gone."""
        for number in range(KEPT, 1, -1):
            with suppress(FileNotFoundError):
                self._numbered(number - 1).replace(self._numbered(number))
        shutil.copy2(self.path, self._numbered(1))

    def _numbered(self, number: int) -> Path:
        return self.path.with_name(f"{self.path.stem}.{number}{self.path.suffix}")
