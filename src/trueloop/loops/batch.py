"""The same work on many parts: here, on local processes, or on the machines of a Dask scheduler."""

from collections.abc import Callable, Iterable, Sequence
from typing import Final, TypeVar

from trueloop.errors import Code, TrueloopError

Item = TypeVar("Item")
Result = TypeVar("Result")

TRIES: Final = 3
"""How often work is given out again whose worker died."""


def run_batch(
    work: Callable[[Item], Result], items: Sequence[Item], *, workers: int = 1, scheduler: str | None = None
) -> list[Result]:
    """Results in the order of the items. `work` is a module's function, its arguments and results can be pickled.

    workers: local processes; 1 works here. scheduler: address of a Dask scheduler, `tcp://host:8786`, which needs the
    extra `cluster`. What a dying worker had in hand is given out again; an exception that `work` raises ends the batch.
    Raises SRF-BATCH when the scheduler cannot be reached, or workers keep dying.
    """
    if scheduler is not None:
        return _on_cluster(work, items, scheduler)
    if workers <= 1 or len(items) < 2:
        return [work(item) for item in items]
    return _on_processes(work, items, workers)


def _on_processes(work: Callable[[Item], Result], items: Sequence[Item], workers: int) -> list[Result]:
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    done: dict[int, Result] = {}
    for _ in range(TRIES):
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            futures = {k: pool.submit(work, item) for k, item in enumerate(items) if k not in done}
            for k, future in futures.items():
                try:
                    done[k] = future.result()
                except BrokenProcessPool:
                    continue
        if len(done) == len(items):
            return [done[k] for k in range(len(items))]
    raise _lost(len(items) - len(done), "a local process died each time: is there memory enough?")


def _on_cluster(work: Callable[[Item], Result], items: Iterable[Item], scheduler: str) -> list[Result]:
    try:
        from distributed import Client, KilledWorker
    except ImportError as missing:
        raise TrueloopError(
            Code.SRF_BATCH,
            f"the scheduler {scheduler!r} needs Dask, which is not installed: {str(missing)!r}",
            hint="pip install 'trueloop[cluster]'",
        ) from None
    try:
        client = Client(scheduler, timeout="10s", set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TypeError) as error:
        raise TrueloopError(
            Code.SRF_BATCH,
            f"the scheduler {scheduler!r} cannot be reached: {error}",
            hint="start one with `dask scheduler` and workers with `dask worker ADDRESS`",
        ) from error
    with client:
        futures = client.map(work, list(items), pure=False, retries=TRIES)
        try:
            return list(client.gather(futures))  # type: ignore[no-untyped-call]
        except KilledWorker as error:
            raise _lost(1, f"workers of the cluster died on it: {error}") from error


def _lost(count: int, why: str) -> TrueloopError:
    return TrueloopError(Code.SRF_BATCH, f"{count} parts could not be worked off in {TRIES} tries", hint=why)
