"""A batch on local processes and on a real Dask scheduler: in order, and nothing lost when a worker is killed."""

import os
import signal
import subprocess
import sys
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.batch_tasks import always_killed, killed_once, refused, squared
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.surface.job import read_surface
from trueloop.loops.batch import AHEAD, run_batch
from trueloop.loops.surface.surface import Work, deviations_of, model_of, pattern_model
from trueloop.report.surface.page import surface_page
from trueloop.surface.deviations.deviations import SurfaceDeviations
from trueloop.surface.separation.separate import Separation

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "surface" / "surface.toml"


INTERRUPTED = """
from tests.support.batch_tasks import slowly
from trueloop.loops.batch import run_batch
if __name__ == "__main__":
    try:
        for number in run_batch(slowly, range(1000), workers=2):
            print(number, flush=True)
    except KeyboardInterrupt:
        print("interrupted")
"""


def test_ctrl_c_is_heard_by_the_program_alone(tmp_path: Path) -> None:
    """A terminal sends it to the workers as well: each of them answered with a traceback."""
    (tmp_path / "interrupted.py").write_text(INTERRUPTED)
    with subprocess.Popen(
        [sys.executable, tmp_path / "interrupted.py"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as program:
        assert program.stdout is not None and program.stdout.readline() == "0\n"
        os.killpg(program.pid, signal.SIGINT)
        said, complained = program.communicate(timeout=60)
    assert said.endswith("interrupted\n") and complained == ""


def same(a: list[SurfaceDeviations], b: list[SurfaceDeviations]) -> bool:
    return all(x.name == y.name and np.array_equal(x.error_mm, y.error_mm) for x, y in zip(a, b, strict=True))


def test_a_local_worker_killed_in_the_middle_loses_nothing(tmp_path: Path) -> None:
    tasks = [(k, str(tmp_path)) for k in range(12)]
    assert list(run_batch(killed_once, tasks, workers=2)) == [k * k for k in range(12)]
    assert (tmp_path / "killed").exists()


def test_a_pool_that_breaks_while_work_is_handed_in_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second task is handed in only after the first one has killed its worker."""
    submit = ProcessPoolExecutor.submit
    first: list[Future[Any]] = []

    def after_the_first(pool: ProcessPoolExecutor, *work: Any) -> Future[Any]:
        if len(first) == 1:
            assert isinstance(first[0].exception(), BrokenProcessPool)
        first.append(submit(pool, *work))
        return first[-1]

    monkeypatch.setattr(ProcessPoolExecutor, "submit", after_the_first)
    assert list(run_batch(killed_once, [(3, str(tmp_path)), (4, str(tmp_path))], workers=2)) == [9, 16]


def test_the_test_by_shuffling_is_made_by_the_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    """It takes most of the time: on a page of many parts it was made here, one part after the other."""
    inputs = read_surface(EXAMPLE).inputs
    here = model_of(inputs.surface, inputs.parts[:3], inputs.options)

    def not_here(separation: Separation) -> float:
        raise AssertionError("shuffled in this process")

    monkeypatch.setattr(Separation, "permutation_p", property(not_here))
    there = model_of(inputs.surface, inputs.parts[:3], inputs.options, work=Work(workers=2))
    assert [part.permutation_p for part in there] == [part.permutation_p for part in here]
    assert surface_page("Three", pattern_model(inputs.surface, there, inputs.options))


@pytest.mark.filterwarnings("ignore")  # of Dask's own making
def test_a_dask_scheduler_with_two_workers_does_the_same_and_survives_a_killed_worker(tmp_path: Path) -> None:
    from distributed import LocalCluster

    inputs = read_surface(EXAMPLE).inputs
    here = list(deviations_of(inputs.surface, inputs.parts[:4], inputs.options))
    with LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=str(tmp_path)
    ) as cluster:
        work = Work(scheduler=cluster.scheduler_address)
        there = list(deviations_of(inputs.surface, inputs.parts[:4], inputs.options, work=work))
        assert same(here, there)
        parts = model_of(inputs.surface, inputs.parts[:3], inputs.options, work=work)
        assert [part.separation.chosen.size.controls > 30 for part in parts] == [True] * 3
        tasks = [(k, str(tmp_path)) for k in range(12)]
        assert list(run_batch(killed_once, tasks, scheduler=cluster.scheduler_address)) == [k * k for k in range(12)]
        assert (tmp_path / "killed").exists()


def test_a_refusal_of_one_part_is_told_as_it_is() -> None:
    with pytest.raises(TrueloopError, match="5 points") as told:
        list(run_batch(refused, [5, 6], workers=2))
    assert told.value.code is Code.SRF_POINTS


def test_what_was_done_before_workers_kept_dying_was_told() -> None:
    results = run_batch(always_killed, range(12), workers=2)
    assert [next(results) for _ in range(5)] == [0, 1, 2, 3, 4]
    with pytest.raises(TrueloopError, match="7 parts") as told:
        next(results)
    assert told.value.code is Code.SRF_BATCH


GIVEN_OUT: list[int] = []


@dataclass(frozen=True)
class Item:
    """A number to whoever works on it; here it notes that it was given out."""

    number: int

    def __reduce__(self) -> tuple[object, ...]:
        GIVEN_OUT.append(self.number)
        return int, (self.number,)


def test_no_more_work_is_given_out_than_will_soon_be_told() -> None:
    """Thousands of parts: neither they nor what became of them are held at once."""
    items: list[Any] = [Item(k) for k in range(500)]
    results = run_batch(squared, items, workers=2)
    assert [next(results) for _ in range(40)] == [k * k for k in range(40)]
    assert 40 <= len(GIVEN_OUT) <= 40 + 2 * AHEAD
