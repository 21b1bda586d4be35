"""Kills the cell client at any moment, and at times the service and the machine; the machine says what was cut.

`python -m scripts.cell_kills FOLDER [KILLS [STEPS [stand-in|linuxcnc [URL]]]]`. The service is `trueloop serve` on a
SQLite store, or on the empty PostgreSQL database at URL. The stand-in (`stand_in_machine.py`) has an operator who
presses Cycle Start when he likes, also twice, and Stop; with LinuxCNC (`lathe_machine.py`) it is `trueloop cell run`
that is killed. A person decides what is held by looking at the machine. Prints what came of it as JSON; ends with 1
where anything is wrong.
"""

import json
import random
import re
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Any, Final, Protocol

from sqlalchemy import select

from trueloop.controllers.linuxcnc.cell.decide import ControlNow
from trueloop.controllers.linuxcnc.cell.journal import known, read
from trueloop.domain.factory import Block, BlockKind, Conditions, PartState, Run, StepState
from trueloop.domain.record import ProgramText
from trueloop.errors import TrueloopError
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.known import OrderNow, PartNow
from trueloop.factory.load import StoreReader, order_of
from trueloop.factory.requests import By, Role
from trueloop.server.identity.keys import NewKey, add_key
from trueloop.storage.schema import RUN_TOUCHES
from trueloop.storage.store import Store, find, keep, open_store

PARTS: Final = 4
ENGINEER, OPERATOR, CELL = By("ana", Role.ENGINEER), By("otto", Role.OPERATOR), By("c", Role.CELL, "lathe")
EXTRA: Final = re.compile(
    rb"o<trueloop-\S+> (if .*|endif)|#<_trueloop_\w+> = 1|M66 P0 L0"
    rb"|\((ABORT,run|LOGAPPEND,trueloop|LOG,O\S+ (started|ended)).*\)"
)


class Machine(Protocol):
    """A machine and its cell; `executed.jsonl` in its folder says what was executed."""

    @property
    def folder(self) -> Path:
        """Its own."""

    @property
    def texts(self) -> Mapping[BlockKind, bytes]:
        """Programs of its blocks."""

    @property
    def longest_s(self) -> float:
        """How long a series may take."""

    def on(self) -> None:
        """Switches it on, again."""

    def killed(self) -> None:
        """The power is gone."""

    def shown(self) -> ControlNow:
        """What a person sees of it."""

    def cell_killed(self, key: str, address: str, drawn: random.Random) -> None:
        """Begins a cell client and kills it without a word, some time later."""

    def settled(self, key: str, address: str) -> None:
        """A client that is not killed delivers all that it knows."""

    def journal(self) -> Path:
        """The client's."""


def main(place: str, kills: int = 100, steps: int = 100, machine: str = "stand-in", url: str = "") -> int:
    """Works until so many steps are done and so many clients killed; says what is wrong."""
    folder, drawn = Path(place), random.Random(7)
    db = url or str(folder / "store.db")
    store = open_store(db, create=True)
    key = add_key(store, NewKey("lathe", "cell", 3), "test", _now()).key
    with ExitStack() as ends:
        lathe = _machine(machine, folder, ends)
        work, killed, until = Work(lathe.texts), Counter[str](), time.monotonic() + lathe.longest_s
        orders = [_planned(store, work, 0)]
        served = ends.enter_context(_Served(folder, db))
        while (killed["cell"] < kills or _recorded(store, orders) < steps) and time.monotonic() < until:
            lathe.cell_killed(key, served.address, drawn)
            killed["cell"] += 1
            print(f"{dict(killed)}, {_recorded(store, orders)} steps", file=sys.stderr, flush=True)
            _person(store, orders[-1], lathe, drawn)
            if _order(store, orders[-1]).state == "done":
                orders.append(_planned(store, work, len(orders)))
            if killed["cell"] % 30 == 0 or (machine == "linuxcnc" and killed["cell"] % 7 == 0):
                served.stop()  # the network is gone while a cut is made
                lathe.cell_killed(key, served.address, drawn)
                served.start()
                killed["service"] += 1
            if machine == "linuxcnc" and killed["cell"] % 4 == 0:
                lathe.killed()
                lathe.on()
                killed["machine"] += 1
        lathe.settled(key, served.address)
        found = _judged(store, orders, lathe, work) | {"kills": dict(killed), "recorded": _recorded(store, orders)}
    print(json.dumps(found | {"store": store.engine.dialect.name}))
    wrong = ("cut_twice", "other_program", "touches_lost", "undelivered")
    return int(any(found[name] for name in wrong) or found["recorded"] < steps or killed["cell"] < kills)


def _machine(name: str, folder: Path, ends: ExitStack) -> Machine:
    if name == "linuxcnc":
        from scripts.lathe_machine import LatheMachine, lathe_machine

        made: LatheMachine = ends.enter_context(lathe_machine(folder))
        return made
    from scripts.stand_in_machine import StandInMachine

    return ends.enter_context(StandInMachine(folder))


@dataclass(frozen=True)
class Work:
    """Programs of the blocks of a part."""

    texts: Mapping[BlockKind, bytes]

    @property
    def sha256(self) -> dict[BlockKind, str]:
        """By block."""
        return {kind: sha256(text).hexdigest() for kind, text in self.texts.items()}

    @property
    def blocks(self) -> tuple[Block, ...]:
        """In their order."""
        return (*(Block(kind, sha) for kind, sha in self.sha256.items()), Block(BlockKind.REMOVE))


def _now() -> datetime:
    return datetime.now(UTC)


def _planned(store: Store, work: Work, number: int) -> str:
    if not number:
        keep(store, [ProgramText(sha, work.texts[kind]) for kind, sha in work.sha256.items()])
        for sha in work.sha256.values():
            carry_out(store, ask.ReleaseProgram(sha, "ran in"), ENGINEER, _now())
    serials = tuple(f"{number}-{k}" for k in range(PARTS))
    plan = ask.PlanOrder("shaft", "", "lathe", serials, work.blocks, "", Conditions(None, None))
    return carry_out(store, plan, ENGINEER, _now()).orders[0].order.id


class _Served:
    """The service as a process of its own, on one port."""

    def __init__(self, folder: Path, db: str) -> None:
        self.folder, self.db, self.port, self.address = folder, db, 0, ""
        self.process: subprocess.Popen[str] | None = None

    def start(self) -> None:
        command = [sys.executable, "-m", "trueloop.cli.main", "serve", "--port", str(self.port), "--db"]
        command = [sys.executable, "-c", "from trueloop.cli.main import main; main()", *command[3:]]
        with (self.folder / "service.log").open("a") as log:
            self.process = subprocess.Popen([*command, self.db], stdout=subprocess.PIPE, stderr=log, text=True)
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


def _order(store: Store, order: str) -> OrderNow:
    with store.reading() as connection:
        return order_of(StoreReader(connection, store.codec), order)


def _recorded(store: Store, orders: list[str]) -> int:
    parts = [part for order in orders for part in _order(store, order).parts]
    return sum(step.state is StepState.RECORDED and step.kind.moves for part in parts for step in part.steps)


def _person(store: Store, order: str, machine: Machine, drawn: random.Random) -> None:
    """Decides on held parts by what the machine shows, takes parts out, and arms the order mostly."""
    now = _order(store, order)
    for part in now.parts:
        if part.state is PartState.HELD:
            _decide(store, order, part, machine)
        elif part.next is not None and part.next.kind is BlockKind.REMOVE:
            carry_out(store, ask.RecordStep(order, part.row, part.next.no, "out"), OPERATOR, _now())
    now = _order(store, order)
    held = any(part.state is PartState.HELD for part in now.parts)
    if not held and now.state != "done" and drawn.random() < 0.8:
        try:
            carry_out(store, ask.Arm(order, 1, "at the machine", True), CELL, _now())
        except TrueloopError:
            return


def _decide(store: Store, order: str, part: PartNow, machine: Machine) -> None:
    step = part.next
    shown = machine.shown()
    if step is None or shown.active or shown.program == f"{step.run}.ngc" or step.state is StepState.STARTED:
        return  # he waits until it stands and shows another program
    seen = [one for one in _done(machine) if one["key"] == step.run]
    verdict = "not-made"
    if seen and step.kind.cuts and step.state is not StepState.WAITING:
        verdict = "made" if seen[0]["whole"] else "reject"
    carry_out(store, ask.DecideStep(order, part.row, step.no, verdict, "looked"), OPERATOR, _now())  # type: ignore[arg-type]


def _done(machine: Machine) -> list[dict[str, Any]]:
    """What the machine has executed: to its end, or to where it was stopped."""
    file = machine.folder / "executed.jsonl"
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def _judged(store: Store, orders: list[str], machine: Machine, work: Work) -> dict[str, Any]:
    runs = {one.value.key: one.value for one in find(store, Run)}
    parts = {one.value.identity: one for order in orders for one in _order(store, order).parts}
    done = _done(machine)
    kinds = {key: work.blocks[run.step].kind for key, run in runs.items()}
    cuts = Counter((runs[o["key"]].part.serial, runs[o["key"]].step) for o in done if kinds[o["key"]].cuts)
    other = sum(not _as_accepted(runs[one["key"]], one["text"].encode("latin-1"), work) for one in done)
    with store.reading() as connection:
        kept = {row.run: row.content for row in connection.execute(select(RUN_TOUCHES))}
    lost = 0
    for one in done:
        run = runs[one["key"]]
        stands = parts[run.part.identity].steps[run.step]
        if one["touches"] and kept.get(run.key, b"").decode() != one["touches"]:
            lost += stands.run == run.key and stands.state is StepState.RECORDED
            lost += stands.run == run.key and stands.state is StepState.ENDED
    entries, _ = read(machine.journal().read_bytes(), machine.journal())
    left = known(entries)
    unknown = sum(one.what == "fact" and one.values["what"] == "unknown" for one in entries)
    return {
        **{"cuts": sum(cuts.values()), "cut_twice": sum(n > 1 for n in cuts.values()), "other_program": other},
        **{"touches": len(kept), "touches_lost": lost, "undelivered": len(left.waiting) + len(left.refused)},
        "unknown": unknown,
    }


def _as_accepted(run: Run, text: bytes, work: Work) -> bool:
    """What was executed is what was sent, and without the lines of the witness what was accepted."""
    own = b"".join(line for line in text.splitlines(True) if not EXTRA.fullmatch(line.strip()))
    return sha256(text).hexdigest() == run.sent_sha256 and own == work.texts[work.blocks[run.step].kind]


if __name__ == "__main__":
    usual = ("", "100", "100", "stand-in", "")
    place, kills, steps, machine, url = (*sys.argv[1:], *usual[len(sys.argv) - 1 :])
    sys.exit(main(place, int(kills), int(steps), machine, url))
