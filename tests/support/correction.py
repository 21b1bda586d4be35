"""Real corrections for tests of the report: the examples' jobs, run once a session."""

from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate

EXAMPLES = Path(__file__).parents[2] / "examples"
NOW = datetime(2026, 1, 31, 8, 15, tzinfo=UTC)


def example_inputs(name: str) -> Inputs:
    """What the example's job names, read; the time and the user's name are the tests'."""
    return replace(read_job(EXAMPLES / name / "job.toml").inputs, made_at=NOW, made_by="a test")


@cache
def example_correction(name: str) -> Correction:
    """The correction of `modbas2`, `piecs11` or `facetst`."""
    return compensate(example_inputs(name))


def size_error_correction() -> Correction:
    """MODBAS2 with every touch 10 µm too large on x: a case for tool offsets."""
    inputs = example_inputs("modbas2")
    touches = replace(inputs.touches, error_mm=0.010 * inputs.touches.outward_normal[:, 0])
    return compensate(replace(inputs, touches=touches))
