"""Every way in which characteristics and their tolerances are refused."""

import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from trueloop.errors import Code
from trueloop.jobs.turned.job import read_job

EXAMPLE = Path(__file__).parents[2] / "examples" / "facetst"


def _asked(*lines: str) -> object:
    """The example's job with characteristics, each of the lines a table's keys."""
    tables = "".join(f"\n[[part.characteristic]]\n{line}\n" for line in lines)
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(EXAMPLE, folder, dirs_exist_ok=True)
        job = Path(folder) / "job.toml"
        job.write_text(job.read_text() + tables)
        return read_job(job)


def _of_cylinder(keys: str) -> object:
    return _asked(f'name = "D1"\nquantity = "diameter"\nfeature = "small-cylinder"\n{keys}')


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.TOL_TEXT: lambda: _of_cylinder('tolerance = "about right"'),
    Code.TOL_FIT: lambda: _of_cylinder('tolerance = "h66"'),
    Code.TOL_SIZE: lambda: _of_cylinder('tolerance = "40 h6"'),
    Code.TOL_ZONE: lambda: _of_cylinder("lower_limit = 1.73\nupper_limit = 1.74"),
    Code.TOL_NOMINAL: lambda: _of_cylinder('nominal = 0.86\ntolerance = "±0.001"'),
    Code.TOL_FEATURE: lambda: _asked('name = "D1"\nquantity = "diameter"\nfeature = "bore"\ntolerance = "±0.001"'),
    Code.TOL_PLACE: lambda: _asked(
        'name = "L1"\nquantity = "length"\nfeature = "end-face"\nother = "end-face"\ntolerance = "±0.001"'
    ),
    Code.TOL_TWICE: lambda: _asked(
        'name = "D1"\nquantity = "diameter"\nfeature = "small-cylinder"\ntolerance = "±0.001"',
        'name = "D2"\nquantity = "diameter"\nfeature = "small-cylinder"\ntolerance = "±0.002"',
    ),
}
