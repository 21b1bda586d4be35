"""Tasks are done once, or again after their worker is gone; the step CORRECT gives what the command line gives."""

import json
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime, timedelta
from functools import partial
from hashlib import sha256
from pathlib import Path

import pytest
from sqlalchemy import insert

from tests.support.factory import AT, CELL, ENGINEER, Shop
from trueloop.domain.factory import Block, BlockKind, Conditions, FactKind, PartState
from trueloop.domain.record import ProgramText
from trueloop.errors import Code, TrueloopError
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.tasks import LEASE_S, Working, lease, run_task, task_of
from trueloop.jobs.factory.runners import RUNNERS, correct
from trueloop.jobs.factory.uploads import HandedFile, order_read
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.turned.compensate import compensate_job
from trueloop.server.apart.reading import PROCESSES, answered, not_read
from trueloop.server.settings import Limits
from trueloop.storage.schema import TASK, stamp
from trueloop.storage.store import Store, keep

MODBAS2 = Path(__file__).parents[3] / "src" / "trueloop" / "examples" / "modbas2"


def add_task(store: Store, kind: str, subject: str, values: Mapping[str, str], by: str, now: datetime) -> int:
    at = stamp(now)
    row = {"kind": kind, "subject": subject, "document": json.dumps(dict(values)), "made_by": by, "state": "waiting"}
    more = {"said": "", "worker": "", "tries": 0, "progress": 0.0, "made_at": at, "changed_at": at}
    with store.writing() as connection:
        done = connection.execute(insert(TASK).values(**row, **more))
        return int((done.inserted_primary_key or (0,))[0])


def test_a_task_is_leased_once_and_again_when_its_worker_is_gone(store: Store) -> None:
    add_task(store, "import", "upload:1", {"upload": "1"}, "ana", AT)
    first = lease(store, "one", AT)
    assert first is not None
    assert lease(store, "two", AT + timedelta(seconds=LEASE_S)) is None
    late = AT + timedelta(seconds=LEASE_S + 1)
    again = lease(store, "two", late)
    assert again is not None
    assert (again.id, again.tries, again.values) == (first.id, 2, {"upload": "1"})
    assert not Working(store, first, "one", lambda: late).say(0.5, "half")
    assert Working(store, again, "two", lambda: late).say(0.5, "half")
    assert lease(store, "three", late + timedelta(seconds=LEASE_S)) is None
    assert task_of(store, first.id).said == "half"


def test_a_task_that_ends_its_worker_each_time_fails_in_the_end(store: Store) -> None:
    number = add_task(store, "import", "upload:1", {}, "ana", AT)
    for k in range(4):
        lease(store, f"worker {k}", AT + timedelta(seconds=k * 2 * LEASE_S))
    task = task_of(store, number)
    assert task.state == "failed"
    assert task.problem is not None
    assert "3 times" in task.problem["message"]


def test_what_a_task_refuses_is_its_problem(store: Store) -> None:
    def refuse(*_: object) -> dict[str, str]:
        raise TrueloopError(Code.FAC_PLAN, "3 of 2", hint="take 2", values={})

    add_task(store, "odd", "x", {}, "ana", AT)
    add_task(store, "nobody knows", "x", {}, "ana", AT)
    done = [run_task(store, {"odd": refuse}, "one", lambda: AT) for _ in range(3)]
    assert [one and one.state for one in done] == ["failed", "failed", None]
    assert [one and one.problem and one.problem["code"] for one in done[:2]] == ["FAC-PLAN", "FAC-UNKNOWN"]


def test_a_task_that_is_done_has_its_result(store: Store) -> None:
    def work(_: Store, task: object, working: Working) -> dict[str, str]:
        assert working.say(0.25, "a quarter")
        return {"rows": "7"}

    number = add_task(store, "work", "x", {}, "ana", AT)
    run_task(store, {"work": work}, "one", lambda: AT)
    task = task_of(store, number)
    assert (task.state, task.progress, task.result) == ("done", 1.0, {"rows": "7"})
    with pytest.raises(TrueloopError, match="no task '99'"):
        task_of(store, 99)


def modbas2(store: Store, job_toml: str) -> Shop:
    """An order of one part by the job of an example, up to its touches."""
    texts = {name: (MODBAS2 / f"{name}.nc").read_bytes() for name in ("semifinish", "finish")}
    texts["probe"] = b"(probe)\nM2\n"
    sha = {name: sha256(text).hexdigest() for name, text in texts.items()}
    keep(store, [ProgramText(sha[name], text) for name, text in texts.items()])
    blocks = (
        Block(BlockKind.SEMIFINISH, sha["semifinish"]),
        Block(BlockKind.PROBE, sha["probe"]),
        Block(BlockKind.CORRECT),
        Block(BlockKind.FINISH, sha["finish"], corrected=True),
    )
    shop = Shop(store)
    for one in sha.values():
        shop.do(ask.ReleaseProgram(one, "ran in"))
    plan = ask.PlanOrder(
        "MODBAS2, 3.52 in", "", "lathe", ("2511.161",), blocks, job_toml, Conditions(None, None), new_machine=True
    )
    shop.order = carry_out(store, plan, ENGINEER, shop.now).orders[0].order.id
    offer = None
    for _ in range(2):
        offer = shop.next()
        assert offer is not None
        shop.tell(offer, FactKind.VERIFIED, FactKind.STARTED, FactKind.ENDED)
    assert offer is not None
    shop.do(ask.RecordTouches(offer.run.key, "touches.csv", (MODBAS2 / "touches.csv").read_bytes()), CELL)
    return shop


def test_the_step_correct_gives_the_finish_cut_its_program(store: Store, tmp_path: Path) -> None:
    store = replace(store, codec=store_codec())
    shop = modbas2(store, (MODBAS2 / "job.toml").read_text(encoding="utf-8"))
    assert shop.next() is None
    task = run_task(store, RUNNERS, "worker", lambda: shop.now)
    assert task is not None
    assert task.state == "done", task.problem
    made, _ = compensate_job(MODBAS2 / "job.toml", tmp_path / "out")
    finish = shop.next()
    assert finish is not None
    wanted = made.corrected_program
    assert len(finish.program) == len(wanted)
    own = [a for a, b in zip(finish.program.splitlines(), wanted.splitlines(), strict=True) if a != b]
    assert all(b"TRUELOOP" in line.upper() for line in own), own
    assert finish.checks[1].startswith("correction")


def test_job_and_touches_are_read_apart_before_they_are_read_here(store: Store) -> None:
    """By the process that reads files: what it cannot read holds the part, and what it can is corrected."""
    store = replace(store, codec=store_codec())
    shop = modbas2(store, (MODBAS2 / "job.toml").read_text(encoding="utf-8"))
    read: list[object] = []

    def first(handed: HandedFile) -> None:
        read.append(answered(Limits(), handed, order_read))
        raise not_read(handed.name, "it takes longer than 30 s")

    task = run_task(store, {"correct": partial(correct, first=first)}, "worker", lambda: shop.now)
    PROCESSES.end()
    assert task is not None and task.state == "failed"
    assert read == [32]
    part = shop.now_is().parts[0]
    assert part.state is PartState.HELD and part.held_why.startswith("SRV-FILE"), part.held_why


def test_a_correction_that_the_loop_refuses_holds_the_part(store: Store) -> None:
    store = replace(store, codec=store_codec())
    toml = (MODBAS2 / "job.toml").read_text(encoding="utf-8") + "\n[compensation]\nmax_correction_um = 1.0\n"
    shop = modbas2(store, toml)
    task = run_task(store, RUNNERS, "worker", lambda: shop.now)
    assert task is not None
    assert task.state == "failed"
    part = shop.now_is().parts[0]
    assert part.state is PartState.HELD
    assert part.held_why.startswith("CMP-SIZE"), part.held_why
    assert shop.next() is None


def test_a_task_done_twice_corrects_once(store: Store) -> None:
    """A worker that is killed after its work, before it could say so."""
    store = replace(store, codec=store_codec())
    shop = modbas2(store, (MODBAS2 / "job.toml").read_text(encoding="utf-8"))
    task = lease(store, "first", shop.now)
    assert task is not None
    before = RUNNERS["correct"](store, task, Working(store, task, "first", lambda: shop.now))
    later = shop.now + timedelta(seconds=LEASE_S + 1)
    done = run_task(store, RUNNERS, "second", lambda: later)
    assert done is not None
    assert (done.state, done.result) == ("done", {"correction": before["correction"]})


def test_a_worker_killed_between_keeping_and_recording_is_made_good(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = replace(store, codec=store_codec())
    shop = modbas2(store, (MODBAS2 / "job.toml").read_text(encoding="utf-8"))

    class Killed(BaseException):
        pass

    def killed(*_: object) -> None:
        raise Killed

    monkeypatch.setattr("trueloop.jobs.factory.runners.carry_out", killed)
    with pytest.raises(Killed):
        run_task(store, RUNNERS, "first", lambda: shop.now)
    monkeypatch.undo()
    later: datetime = shop.now + timedelta(seconds=LEASE_S + 1)
    done = run_task(store, RUNNERS, "second", lambda: later)
    assert done is not None
    assert done.state == "done", done.problem
    shop.now = later
    assert shop.next() is not None
