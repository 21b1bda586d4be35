"""A shop to look around in: the shipped examples, taken through the commands' own functions into a new store."""

from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from trueloop.domain.factory import Block, BlockKind, Conditions, FactKind, RunFact
from trueloop.domain.record import Program, ProgramText, sha256_of
from trueloop.factory import requests
from trueloop.factory.book import read_book
from trueloop.factory.carry_out import carry_out
from trueloop.factory.known import Offer
from trueloop.factory.requests import By, Role
from trueloop.formats.examples import copy_example, example
from trueloop.formats.input_file import read_program
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.jobs.measure.keep_measured import StatedCut, keep_measured
from trueloop.jobs.measure.measured import Chosen, read_measured, read_part_of_job
from trueloop.jobs.series import Adding, accepted, add_inspections, propose
from trueloop.jobs.store.opened import Keeping, make_store
from trueloop.jobs.turned.compensate import compensate_and_keep
from trueloop.loops.post_process.series import SeriesOptions
from trueloop.storage.store import Store, keep

FILE: Final = "trueloop-demo.db"
MACHINE: Final = "example lathe"
WHO: Final = "example"
_ENGINEER: Final = By(WHO, Role.ENGINEER)
_CELL: Final = By(WHO, Role.CELL, MACHINE)


def make_example_shop(file: Path) -> None:
    """Makes a store with two parts of an edge, a series with a decided proposal, and an order on a machine.

    Everything in it is a result of the product's own functions on the examples; the runs of the order are stated by
    the account `example`, since no machine is connected. The store appears under its name only when it is whole.
    Raises STO errors.
    """
    unfinished = file.with_name(f"{file.name}.unfinished")
    unfinished.unlink(missing_ok=True)  # of a run that was interrupted
    store = make_store(str(unfinished))
    with TemporaryDirectory() as folder:
        _edge_parts(store.where, Path(folder))
    _series(store)
    _order(store)
    store.close()
    unfinished.replace(file)


def _edge_parts(db: str, folder: Path) -> None:
    """The first part of an edge as touched, corrected and measured; the second corrected with what the first left."""
    jobs = _copies("edge", folder), _copies("modbas2", folder)
    job = jobs[0] / "edge.toml"
    for count, serial in enumerate(("S1", "S2"), 1):
        (job.parent / "touches.csv").write_bytes((job.parent / f"touches-{count}.csv").read_bytes())
        compensate_and_keep(job, folder / "out", Keeping(db, serial))
        finished = job.parent / f"finish-{count}.csv"
        if finished.exists():
            found = read_measured(finished, StatedFacts(), read_part_of_job(job), Chosen(serial))
            keep_measured([found], job, StatedCut("finish"), Keeping(db, serial))


def _copies(name: str, folder: Path) -> Path:
    copy_example(name, folder / name)
    return folder / name


def _series(store: Store) -> None:
    """Three shafts, the tool offset that they lead to, which is accepted, and two shafts cut with it."""
    options, job = SeriesOptions(), example("shaft/job.toml")
    (first,) = add_inspections(store, [example("series/first-three.csv")], Adding())
    for one in propose(store, read_book(store, first.part_type, options), options, job).proposals:
        accepted(store, one.id, options, None, who=WHO, why="three parts agree", override=())
    add_inspections(store, [example("series/next-two.csv")], Adding())


def _order(store: Store) -> None:
    """Four parts on one machine: the first is off the machine, the second is held, two wait."""
    finish = read_program(example("linuxcnc/finish.ngc"))
    sha = sha256_of(finish.source)
    keep(store, [Program("finish.ngc", "linuxcnc", sha, "inch"), ProgramText(sha, finish.source)])
    blocks = [Block(BlockKind.FINISH, sha), *map(Block, (BlockKind.REMOVE, BlockKind.MEASURE, BlockKind.RELEASE))]
    free = Conditions(temperature_age_s=None, calibration_age_s=None)
    serials = ("D1", "D2", "D3", "D4")
    plan = requests.PlanOrder(
        *("MODBAS2, 3.52 in, LinuxCNC", "", MACHINE, serials, tuple(blocks)), conditions=free, new_machine=True
    )
    _do(store, requests.ReleaseProgram(sha, "the example's program"), _ENGINEER)
    order = carry_out(store, plan, _ENGINEER, datetime.now(UTC)).orders[0]
    first = _run_next(store)
    _do(store, requests.RecordStep(order.order.id, first, 1, "taken off by hand"), _ENGINEER)
    held = _run_next(store)
    _do(store, requests.Hold(order.order.id, held, "a chip lay on the datum face"), _ENGINEER)


def _run_next(store: Store) -> int:
    """The machine's next block, reported as run; returns the number of its part."""
    offer = _do(store, requests.NextBlock(MACHINE), _CELL)
    assert isinstance(offer, Offer)
    for kind in (FactKind.SENT, FactKind.VERIFIED, FactKind.STARTED, FactKind.ENDED):
        values = {"read_back_sha256": offer.run.sent_sha256} if kind is FactKind.VERIFIED else {}
        _do(store, requests.RecordFacts((RunFact(offer.run.key, kind, datetime.now(UTC), WHO, values),)), _CELL)
    return int(offer.run.key.split(".")[1])


def _do(store: Store, request: requests.Request, by: By) -> object:
    return carry_out(store, request, by, datetime.now(UTC)).answer
