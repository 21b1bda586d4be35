"""Kills a program that carries out orders in a store, at any moment, and looks at what is left.

`python -m scripts.factory_kills PLACE [COUNT]`, where PLACE is a new file or an empty database. It kills so often, and
goes on until so many facts were told, on a busy computer MOST_TIMES as often at most. Each time a process
asks for blocks and reports their facts, and says so one by one; it is killed without warning. Then the store must open;
every fact that was acknowledged must be there; each step must stand where its facts say, with the events of its way; no
step may have been offered twice, but where a person decided so. Prints what came of it as JSON; ends with 1 where
anything is wrong; meanwhile on stderr how far it is.
"""

import json
import os
import random
import sys
from collections import Counter
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import partial
from hashlib import sha256
from typing import Final

from scripts.store_kills import killed
from trueloop.domain.factory import Block, BlockKind, Conditions, FactKind, PartState, Run, RunFact, StepState
from trueloop.domain.record import ProgramText
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.decisions.runs import state_of
from trueloop.factory.known import OrderNow
from trueloop.factory.load import StoreReader, order_of, runs_of
from trueloop.factory.requests import By, Role
from trueloop.storage.integrity import damage
from trueloop.storage.store import Store, find, keep, open_store

PARTS: Final = 30
WITHIN_S: Final = 0.4
"""A cell is killed within this time of its first word: it carries out some steps meanwhile."""
MOST_TIMES: Final = 4
TOLD_EVERY: Final = 20
TEXT: Final = b"(cut)\nM2\n"
SHA: Final = sha256(TEXT).hexdigest()
BLOCKS: Final = (Block(BlockKind.SEMIFINISH, SHA), Block(BlockKind.FINISH, SHA), Block(BlockKind.INSPECT, SHA))
ENGINEER, OPERATOR = By("ana", Role.ENGINEER), By("otto", Role.OPERATOR)
CELL: Final = By("cell", Role.CELL, "lathe")
TOLD: Final = (FactKind.SENT, FactKind.VERIFIED, FactKind.STARTED, FactKind.ENDED)


@dataclass
class Tally:
    """Of how many kills; what was done; and what must stay 0."""

    kills: int = 0
    acknowledged: int = 0
    unknown: int = 0
    lost: int = 0
    offered_twice: int = 0
    not_as_its_facts: int = 0
    without_event: int = 0
    damaged: int = 0


def main(place: str, count: int = 100) -> int:
    """Makes the orders, kills who carries them out, and says what came of it."""
    store = open_store(place, create=True)
    keep(store, [ProgramText(SHA, TEXT)])
    carry_out(store, ask.ReleaseProgram(SHA, "ran in"), ENGINEER, _now())
    drawn, tally = random.Random(1), Tally()
    order = _planned(store, 0)
    store.close()
    while tally.kills < count or (tally.acknowledged < count and tally.kills < MOST_TIMES * count):
        acknowledged = killed(partial(_work, place), drawn.uniform(0.0, WITHIN_S))
        store = open_store(place)
        _look_at(store, order, acknowledged, tally)
        if sum(one.next is None for one in _order(store, order).parts) > PARTS // 2:
            order = _planned(store, tally.kills)
        store.close()
        if tally.kills % TOLD_EVERY == 0:
            print(json.dumps(asdict(tally)), file=sys.stderr, flush=True)
    print(json.dumps(asdict(tally)))
    wrong = (tally.lost, tally.offered_twice, tally.not_as_its_facts, tally.without_event, tally.damaged)
    return int(any(wrong))


def _now() -> datetime:
    return datetime.now(UTC)


def _planned(store: Store, number: int) -> str:
    """An order; what is left of the one before is rejected, so that the machine is free."""
    serials = tuple(f"{number}-{k}" for k in range(PARTS))
    plan = ask.PlanOrder("shaft", "", "lathe", serials, BLOCKS, "", Conditions(None, None), new_machine=True)
    for before in find(store, Run)[-1:]:
        for part in _order(store, before.value.order).parts:
            if part.next is not None and not part.rejected:
                _reject(store, before.value.order, part.row, part.next.no)
    return carry_out(store, plan, ENGINEER, _now()).orders[0].order.id


def _reject(store: Store, order: str, row: int, step: int) -> None:
    carry_out(store, ask.Hold(order, row, "over"), OPERATOR, _now())
    carry_out(store, ask.DecideStep(order, row, step, "reject", "over"), OPERATOR, _now())


def _order(store: Store, order: str) -> OrderNow:
    with store.reading() as connection:
        return order_of(StoreReader(connection, store.codec), order)


def _work(place: str, says: int) -> None:
    """A cell without a journal: it asks, and tells all facts of what it was given."""
    store = open_store(place, wait_s=60)
    os.write(says, b"[]\n")
    while True:
        offer = carry_out(store, ask.NextBlock("lathe"), CELL, _now()).answer
        if offer is None:
            os.write(says, b"[]\n")
            continue
        for kind in TOLD:
            values = {"read_back_sha256": offer.run.sent_sha256} if kind is FactKind.VERIFIED else {}
            fact = RunFact(offer.run.key, kind, _now(), "cell", values)
            carry_out(store, ask.RecordFacts((fact,)), CELL, _now())
            os.write(says, json.dumps([fact.run, fact.what.value, fact.at.isoformat()]).encode() + b"\n")
        if offer.block.kind is BlockKind.INSPECT:
            carry_out(store, ask.RecordTouches(offer.run.key, "t.csv", offer.run.key.encode()), CELL, _now())


def _look_at(store: Store, order: str, acknowledged: list[str], tally: Tally) -> None:
    told = [json.loads(one) for one in acknowledged]
    said = [tuple(one) for one in told if one]
    tally.kills += 1
    tally.acknowledged += len(said)
    kept = {(one.value.run, one.value.what.value, one.value.at.isoformat()) for one in find(store, RunFact)}
    tally.lost += len([one for one in said if one not in kept])
    tally.damaged += len(damage(store))
    _look_at_steps(store, order, tally)
    for part in _order(store, order).parts:  # what it has measured and not told, a cell's journal has
        step = part.next
        if step is not None and step.kind is BlockKind.INSPECT and step.state is StepState.ENDED:
            carry_out(store, ask.RecordTouches(step.run, "t.csv", step.run.encode()), CELL, _now())
    for part in _order(store, order).parts:  # what the killed cell had begun: a person has looked at it
        if part.state is PartState.HELD and part.next is not None:
            tally.unknown += 1
            verdict: ask.Verdict = "made" if part.next.kind.cuts else "not-made"
            carry_out(store, ask.DecideStep(order, part.row, part.next.no, verdict, "looked"), OPERATOR, _now())


def _look_at_steps(store: Store, order: str, tally: Tally) -> None:
    now = _order(store, order)
    attempts = Counter((one.value.part.serial, one.value.step) for one in find(store, Run, work_order=order))
    with store.reading() as connection:
        known = StoreReader(connection, store.codec)
        again = {
            (row, json.loads(said).get("step"))
            for row, said in connection.exec_driver_sql("SELECT subject, document FROM event WHERE what = 'decided'")
        }
        recorded = Counter(
            json.loads(said)["run"]
            for (said,) in connection.exec_driver_sql("SELECT document FROM event WHERE what = 'recorded'")
        )
        begun = [(part, step) for part in now.parts for step in part.steps if step.run]
        runs = runs_of(known, [step.run for _, step in begun]).runs
        for part, step in begun:
            decided = (f"part:{part.row}", str(step.no)) in again
            one = runs[step.run]
            wanted = state_of(step.kind, one.run, one.facts, bool(one.touches))
            tally.offered_twice += attempts[part.value.serial, step.no] > 1 and not decided
            tally.not_as_its_facts += step.state is not wanted and not decided
            tally.without_event += step.state is StepState.RECORDED and not recorded[step.run] and not decided


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], *map(int, sys.argv[2:3])))
