"""Kills the cell client at any moment, and at times the service; a stand-in for the machine says what was cut.

`python -m scripts.cell_kills FOLDER [KILLS [STEPS]]`. The service is `trueloop serve` on a SQLite store, the machine a
process of its own (`StandIn`), whose operator presses Cycle Start when he likes, also twice, and Stop. A person decides
what is held by looking at the machine. Prints what came of it as JSON; ends with 1 where anything is wrong.
"""

import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from sqlalchemy import select

from scripts.stand_in_machine import Remote, serve_machine
from trueloop.controllers.linuxcnc.cell.client import Client, Pace
from trueloop.controllers.linuxcnc.cell.decide import Patience
from trueloop.controllers.linuxcnc.cell.journal import Journal
from trueloop.controllers.linuxcnc.cell.service import Service
from trueloop.domain.factory.route import Block, BlockKind, Conditions
from trueloop.domain.factory.run import Run
from trueloop.domain.factory.states import PartState, StepState
from trueloop.domain.program import ProgramText
from trueloop.errors import TrueloopError
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.known import OrderNow, PartNow
from trueloop.factory.load import Known, order_of
from trueloop.factory.roles import By, Role
from trueloop.server.identity.keys import NewKey, add_key
from trueloop.storage.factory_tables import RUN_TOUCHES
from trueloop.storage.store import Store, find, keep, open_store

WITHIN_S: Final = 0.6
PARTS: Final = 4
PACE: Final = Pace(0.004, 0.01, 0.1, 0.05, Patience(0.05, 0.15, 0.3))
TEXTS: Final = {
    BlockKind.SEMIFINISH: b"%\n(first cut, no M2 here)\nG21 G90 G94 F100\nG1 X1\nG1 X2\nM30\n%\n",
    BlockKind.PROBE: b"(PROBEOPEN touches.txt)\nG38.2 X0 F60\nG0 X1\n(PROBECLOSE)\nM2\n",
    BlockKind.FINISH: b"G1 X0.99\r\nG1 X1.99 ; to the shoulder\r\nM5\r\nM30\r\n",
}
SHA: Final = {kind: sha256(text).hexdigest() for kind, text in TEXTS.items()}
BLOCKS: Final = (*(Block(kind, SHA[kind]) for kind in TEXTS), Block(BlockKind.REMOVE))
ENGINEER, OPERATOR, CELL = By("ana", Role.ENGINEER), By("otto", Role.OPERATOR), By("c", Role.CELL, "lathe")
EXTRA: Final = re.compile(rb"o<trueloop-\S+> (if .*|endif)|#<_trueloop_\w+> = 1|\((ABORT|LOGAPPEND|LOG),.*\)|M66 P0 L0")


def main(place: str, kills: int = 100, steps: int = 100) -> int:
    """Works until so many steps are done and so many clients killed; says what is wrong."""
    folder, drawn = Path(place), random.Random(7)
    (folder / "machine").mkdir()
    store = open_store(str(folder / "store.db"), create=True)
    key = add_key(store, NewKey("lathe", "cell", 3), "test", _now()).key
    orders = [_planned(store, 0)]
    machine, killed, until = serve_machine(folder / "machine"), 0, time.monotonic() + 240
    try:
        with _Served(folder) as served:
            while (killed < kills or _recorded(store, orders) < steps) and time.monotonic() < until:
                _killed(folder, key, served.address, drawn.uniform(0, WITHIN_S))
                killed += 1
                _person(store, orders[-1], folder, drawn)
                if _order(store, orders[-1]).state == "done":
                    orders.append(_planned(store, len(orders)))
                if killed % 30 == 0:  # the network is gone while a cut is made
                    served.stop()
                    _killed(folder, key, served.address, WITHIN_S)
                    served.start()
            _settled(folder, key, served.address)
        found = _judged(store, orders, folder) | {"kills": killed, "recorded": _recorded(store, orders)}
    finally:
        os.kill(machine, signal.SIGKILL)
        os.waitpid(machine, 0)
    print(json.dumps(found))
    wrong = ("cut_twice", "other_program", "touches_lost", "undelivered")
    return int(any(found[name] for name in wrong) or found["recorded"] < steps or killed < kills)


def _now() -> datetime:
    return datetime.now(UTC)


def _planned(store: Store, number: int) -> str:
    if not number:
        _released(store)
    serials = tuple(f"{number}-{k}" for k in range(PARTS))
    plan = ask.PlanOrder("shaft", "", "lathe", serials, BLOCKS, "", Conditions(None, None))
    return carry_out(store, plan, ENGINEER, _now()).orders[0].order.id


def _released(store: Store) -> None:
    keep(store, [ProgramText(SHA[kind], text) for kind, text in TEXTS.items()])
    for sha in SHA.values():
        carry_out(store, ask.ReleaseProgram(sha, "ran in"), ENGINEER, _now())


class _Served:
    """The service as a process of its own, on one port."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.port, self.address = folder, 0, ""
        self.process: subprocess.Popen[str] | None = None

    def start(self) -> None:
        command = [sys.executable, "-m", "trueloop.cli.main", "serve", "--port", str(self.port), "--db"]
        command = [sys.executable, "-c", "from trueloop.cli.main import main; main()", *command[3:]]
        with (self.folder / "service.log").open("a") as log:
            self.process = subprocess.Popen(
                [*command, str(self.folder / "store.db")], stdout=subprocess.PIPE, stderr=log, text=True
            )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().split()[-1].rstrip("/")
        self.port = int(self.address.rpartition(":")[2])

    def stop(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            assert self.process.stdout is not None
            self.process.stdout.close()

    def __enter__(self) -> "_Served":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def _killed(folder: Path, key: str, address: str, after_s: float) -> None:
    """A client in a process of its own, killed without a word."""
    child = os.fork()
    if child == 0:
        try:
            _work(folder, key, address, 60.0)
        except BaseException as wrong:  # a fault shows in the tally: nothing more is recorded
            (folder / "fault.txt").write_text(repr(wrong))
        os._exit(1)
    time.sleep(after_s)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def _work(folder: Path, key: str, address: str, for_s: float) -> Client:
    with _journal(folder) as journal:
        control = Remote(folder / "machine")
        client = Client("lathe", control, Service(address, key), journal, PACE)
        end = time.monotonic() + for_s
        while time.monotonic() < end:
            if not client.step():
                time.sleep(PACE.look_s)
        return client


@contextmanager
def _journal(folder: Path) -> Iterator[Journal]:
    journal = Journal(folder / "cell.journal")
    try:
        yield journal
    finally:
        journal.close()


def _settled(folder: Path, key: str, address: str) -> None:
    """The last client is not killed: all that is known gets delivered."""
    _work(folder, key, address, 1.0)


def _order(store: Store, order: str) -> OrderNow:
    with store.reading() as connection:
        return order_of(Known(connection, store.codec), order)


def _recorded(store: Store, orders: list[str]) -> int:
    parts = [part for order in orders for part in _order(store, order).parts]
    return sum(step.state is StepState.RECORDED and step.kind.moves for part in parts for step in part.steps)


def _person(store: Store, order: str, folder: Path, drawn: random.Random) -> None:
    """Decides on held parts by what the machine shows, takes parts out, and arms the order mostly."""
    now, control = _order(store, order), Remote(folder / "machine")
    for part in now.parts:
        if part.state is PartState.HELD:
            _decide(store, order, part, folder, control)
        elif part.next is not None and part.next.kind is BlockKind.REMOVE:
            carry_out(store, ask.RecordStep(order, part.row, part.next.no, "out"), OPERATOR, _now())
    now = _order(store, order)
    held = any(part.state is PartState.HELD for part in now.parts)
    if not held and now.state != "done" and drawn.random() < 0.8:
        try:
            carry_out(store, ask.Arm(order, 1, "at the machine", True), CELL, _now())
        except TrueloopError:
            return


def _decide(store: Store, order: str, part: PartNow, folder: Path, control: Remote) -> None:
    step = part.next
    shown = control.now()
    if step is None or shown.active or shown.program == f"{step.run}.ngc" or step.state is StepState.STARTED:
        return  # he waits until it stands and shows another program
    seen = [one for one in _done(folder) if one["key"] == step.run]
    verdict = "not-made"
    if seen and step.kind.cuts and step.state is not StepState.WAITING:
        verdict = "made" if seen[0]["whole"] else "reject"
    carry_out(store, ask.DecideStep(order, part.row, step.no, verdict, "looked"), OPERATOR, _now())  # type: ignore[arg-type]


def _done(folder: Path) -> list[dict[str, Any]]:
    """What the machine has executed: to its end, or to where it was stopped."""
    file = folder / "machine" / "executed.jsonl"
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def _judged(store: Store, orders: list[str], folder: Path) -> dict[str, int]:
    runs = {one.value.key: one.value for one in find(store, Run)}
    parts = {one.value.identity: one for order in orders for one in _order(store, order).parts}
    done = _done(folder)
    cuts = Counter((runs[o["key"]].part.serial, runs[o["key"]].step) for o in done if _kind(runs[o["key"]]).cuts)
    other = sum(not _as_accepted(runs[one["key"]], one["text"].encode("latin-1")) for one in done)
    with store.reading() as connection:
        kept = {row.run: row.content for row in connection.execute(select(RUN_TOUCHES))}
    lost = 0
    for one in done:
        run = runs[one["key"]]
        stands = parts[run.part.identity].steps[run.step]
        if one["touches"] and kept.get(run.key, b"").decode() != one["touches"]:
            lost += stands.run == run.key and stands.state is StepState.RECORDED
            lost += stands.run == run.key and stands.state is StepState.ENDED
    with _journal(folder) as journal:
        from trueloop.controllers.linuxcnc.cell.known import known

        left = known(journal.entries)
        unknown = sum(one.what == "fact" and one.values["what"] == "unknown" for one in journal.entries)
    return {
        **{"cuts": sum(cuts.values()), "cut_twice": sum(n > 1 for n in cuts.values()), "other_program": other},
        **{"touches": len(kept), "touches_lost": lost, "undelivered": len(left.waiting) + len(left.refused)},
        "unknown": unknown,
    }


def _kind(run: Run) -> BlockKind:
    return BLOCKS[run.step].kind


def _as_accepted(run: Run, text: bytes) -> bool:
    """What was executed is what was sent, and without the lines of the witness what was accepted."""
    own = b"".join(line for line in text.splitlines(True) if not EXTRA.fullmatch(line.strip()))
    return sha256(text).hexdigest() == run.sent_sha256 and own == TEXTS[_kind(run)]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], *map(int, sys.argv[2:])))
