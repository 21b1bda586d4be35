"""The log of signals: `time_s` (s since 1970), T1_degC, spindle_rpm …, a row a second, as `read_history` reads it.

The file by itself always reaches back as far as lags need: when it is full it is begun anew with its last rows, and
what it held before is kept beside it.
"""

import shutil
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import TrueloopError
from trueloop.formats.measurements.history_csv import read_history
from trueloop.formats.outputs import write_all
from trueloop.machine.model.history import History

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
        """Returns the readings recorded before; None where they cannot be continued: no log, one of other signals, one
        from the future, one that cannot be read.
        """
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
