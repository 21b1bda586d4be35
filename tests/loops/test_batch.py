"""A batch on local processes and on a real Dask scheduler: in order, and nothing lost when a worker is killed."""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.gauging.surface_deviations import SurfaceDeviations
from trueloop.loops.batch import run_batch
from trueloop.loops.surface import deviations_of
from trueloop.loops.surface_inputs import read_surface_inputs

EXAMPLE = Path(__file__).parents[2] / "examples" / "surface" / "surface.toml"


def killed_once(task: tuple[int, str]) -> int:
    """Kills the process it runs in, the first time it is given task 3."""
    number, folder = task
    mark = Path(folder) / "killed"
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.02)
    return number * number


def refused(number: int) -> int:
    raise TrueloopError(Code.SRF_POINTS, f"{number} points", hint="more")


def same(a: list[SurfaceDeviations], b: list[SurfaceDeviations]) -> bool:
    return all(x.name == y.name and np.array_equal(x.error_mm, y.error_mm) for x, y in zip(a, b, strict=True))


def test_a_local_worker_killed_in_the_middle_loses_nothing(tmp_path: Path) -> None:
    tasks = [(k, str(tmp_path)) for k in range(12)]
    assert run_batch(killed_once, tasks, workers=2) == [k * k for k in range(12)]
    assert (tmp_path / "killed").exists()


@pytest.mark.filterwarnings("ignore")  # of Dask's own making
def test_a_dask_scheduler_with_two_workers_does_the_same_and_survives_a_killed_worker(tmp_path: Path) -> None:
    from distributed import LocalCluster

    inputs = read_surface_inputs(EXAMPLE)
    here = deviations_of(inputs.surface, inputs.parts[:4], inputs.options)
    with LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=str(tmp_path)
    ) as cluster:
        there = deviations_of(inputs.surface, inputs.parts[:4], inputs.options, scheduler=cluster.scheduler_address)
        assert same(here, there)
        tasks = [(k, str(tmp_path)) for k in range(12)]
        assert run_batch(killed_once, tasks, scheduler=cluster.scheduler_address) == [k * k for k in range(12)]
        assert (tmp_path / "killed").exists()


def test_a_refusal_of_one_part_is_told_as_it_is() -> None:
    with pytest.raises(TrueloopError, match="5 points") as told:
        run_batch(refused, [5, 6], workers=2)
    assert told.value.code is Code.SRF_POINTS
