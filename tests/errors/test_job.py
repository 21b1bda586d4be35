"""Every way in which a job file is refused."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from tests.support import grooved
from trueloop.errors import Code
from trueloop.formats.jobs.job import read_turned_job
from trueloop.jobs.turned.job import read_job
from trueloop.jobs.turned.new import Wanted, new_job


def _read(text: str) -> object:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "job.toml"
        path.write_text(text)
        return read_turned_job(path)


def _begun_twice() -> None:
    example = Path(__file__).parents[2] / "examples" / "linuxcnc" / "finish.ngc"
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(2):
            new_job(Wanted(example, 0.79375, "part", Path(folder)))


def _several_tools() -> object:
    with tempfile.TemporaryDirectory() as folder:
        return read_job(grooved.job(Path(folder), [0.0] * len(grooved.PLACES)))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.JOB_MISSING: lambda: read_turned_job(Path("/nowhere/job.toml")),
    Code.JOB_SYNTAX: lambda: _read("[part]\nname = dome\n"),
    Code.JOB_KEY: lambda: _read("[part]\nname = 'dome'\nfrom_program = true\nunits = 'mm'\n"),
    Code.JOB_EXISTS: _begun_twice,
    Code.JOB_TOOLS: _several_tools,
}
