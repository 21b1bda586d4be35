"""PIECS11's job beside a store, its part corrected, finished and inspected as a user does it."""

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from typer.testing import Result

from tests.support.cli import invoke
from tests.support.correction import EXAMPLES
from trueloop.arrays import Array
from trueloop.domain.record import Correction
from trueloop.domain.tool import Edge, Tool
from trueloop.jobs.store.opened import store_of
from trueloop.storage.store import Store, find, open_store

TOOL = 'name = "PCLNL"\ninsert = "CNMG"\ncorner = "2"\n'
EDGE = Edge(Tool(1, "PCLNL"), "CNMG", "2")
SERIAL = "3511.158"
FINISH = np.concatenate([np.zeros(1), np.full(5, 1.0), np.linspace(-6.0, 8.0, 20)])
"""Errors in µm after the finish cut at the 26 points of the job: the flange face, from which z counts, first."""


@dataclass
class JobInStore:
    """The job's folder, and what the last command said."""

    folder: Path
    said: Result | None = None

    @property
    def job(self) -> Path:
        return self.folder / "job.toml"

    @property
    def store(self) -> Store:
        store = store_of(self.folder, None, None)
        assert store is not None
        return store

    @property
    def correction(self) -> Correction[object]:
        return find(self.store, Correction)[0].value

    def correct(self, serial: str, factor: float = 1.0) -> Result:
        """Corrects another part of the job, whose touches are those of the first by a factor."""
        touches = self.folder / "touches.csv"
        if factor != 1.0:
            head, *rows = self.rows
            errors = [f"{','.join(row.split(',')[:-1])},{factor * float(row.split(',')[-1]):.3f}" for row in rows]
            touches.write_text("\n".join([head, *errors, ""]), encoding="utf-8")
        self.said = invoke("compensate", self.job, "--serial", serial, status=0)
        return self.said

    @property
    def rows(self) -> list[str]:
        text = (EXAMPLES / "piecs11" / "touches.csv").read_text(encoding="utf-8")
        return [line for line in text.splitlines() if not line.startswith("#")]

    def finish(
        self, errors_um: Array | Path, *options: object, serial: str = SERIAL, after: str = "finish", status: int = 0
    ) -> Result:
        """Hands in the errors after the finish cut."""
        file = errors_um if isinstance(errors_um, Path) else self.folder / "after.csv"
        if not isinstance(errors_um, Path):
            head, *rows = self.rows
            found = [f"{','.join(row.split(',')[:-1])},{um:.6f}" for row, um in zip(rows, errors_um, strict=False)]
            file.write_text("\n".join([head, *found, ""]), encoding="utf-8")
        given = ("--job", self.job, "--after", after, "--serial", serial)
        self.said = invoke("measure", "read", file, *given, *options, status=status)
        return self.said


def job_in_store(folder: Path, *, correct: bool = True) -> JobInStore:
    """The job in a folder, its edge stated, its touches of 8 o'clock; corrected and kept as part 3511.158."""
    for file in (EXAMPLES / "piecs11").iterdir():
        shutil.copy(file, folder)
    job = folder / "job.toml"
    text = job.read_text(encoding="utf-8").replace("[tool]\n", f"[tool]\n{TOOL}").replace("../../out/piecs11", "out")
    text = text.replace("[gauging]\n", "[gauging]\nmeasured_at = 2026-01-06T08:00:00Z\n")
    job.write_text(f"{text}\n[compensation]\nmax_age_hours = 1e6\n", encoding="utf-8")
    open_store(folder / "trueloop.db", create=True)
    made = JobInStore(folder)
    if correct:
        made.correct(SERIAL)
    return made
