"""Every way in which a job file is refused."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from trueloop.errors import Code
from trueloop.formats.jobs.job import read_turned_job


def _read(text: str) -> object:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "job.toml"
        path.write_text(text)
        return read_turned_job(path)


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.JOB_MISSING: lambda: read_turned_job(Path("/nowhere/job.toml")),
    Code.JOB_SYNTAX: lambda: _read("[part]\nname = dome\n"),
    Code.JOB_KEY: lambda: _read("[part]\nname = 'dome'\nfrom_program = true\nunits = 'mm'\n"),
}
