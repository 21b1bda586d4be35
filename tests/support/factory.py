"""A shop for tests: a store with released programs, an order of two parts, and a cell that reports what it does."""

from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from hashlib import sha256
from typing import Any

from trueloop.domain.factory import Block, BlockKind, Conditions, FactKind, RunFact
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import Correction, Product, Program, ProgramText, Record
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.known import Offer, OrderNow
from trueloop.factory.load import StoreReader, order_of
from trueloop.factory.requests import By, Role
from trueloop.storage.store import Store, keep

AT = datetime(2026, 3, 4, 5, 6, 7, tzinfo=UTC)
TEXTS = {
    name: f"(program {name})\nG1 X1\nM2\n".encode() for name in ("rough", "semifinish", "probe", "finish", "inspect")
}
SHA = {name: sha256(text).hexdigest() for name, text in TEXTS.items()}
BLOCKS = (
    Block(BlockKind.SEMIFINISH, SHA["semifinish"], "dome"),
    Block(BlockKind.PROBE, SHA["probe"]),
    Block(BlockKind.CORRECT),
    Block(BlockKind.FINISH, SHA["finish"], "dome", corrected=True),
    Block(BlockKind.REMOVE),
    Block(BlockKind.RELEASE),
)
PLAN = ask.PlanOrder(
    "shaft", "B", "lathe", ("a", "b"), BLOCKS, "[part]", Conditions(1800.0, 86_400.0, None), new_machine=True
)
ENGINEER, OPERATOR = By("ana", Role.ENGINEER), By("otto", Role.OPERATOR)
VIEWER, CELL = By("vera", Role.VIEWER), By("cell", Role.CELL, "lathe")
SERVICE = By("service", Role.SERVICE)


@dataclass
class Shop:
    """One store and one order, and the time as the test turns it."""

    store: Store
    now: datetime = AT
    order: str = ""
    conditions: Conditions = field(default_factory=lambda: PLAN.conditions)

    def do(self, request: ask.Request, by: By = ENGINEER, expected: str | None = None) -> Any:
        self.now += timedelta(seconds=1)
        return carry_out(self.store, request, by, self.now, expected).answer

    def set_up(self, plan: ask.PlanOrder = PLAN) -> "Shop":
        keep_programs(self.store)
        for sha in SHA.values():
            self.do(ask.ReleaseProgram(sha, "ran in"))
        self.order = carry_out(self.store, plan, ENGINEER, self.now).orders[0].order.id
        self.do(ask.Calibrated("lathe"), OPERATOR)
        self.warm()
        return self

    def warm(self) -> None:
        self.do(ask.RecordTemperatures("lathe", {"spindle": 23.5}, self.now), CELL)

    def now_is(self) -> OrderNow:
        with self.store.reading() as connection:
            return order_of(StoreReader(connection, self.store.codec), self.order)

    def next(self) -> Offer | None:
        offer: Offer | None = self.do(ask.NextBlock("lathe"), CELL)
        return offer

    def tell(self, offer: Offer, *kinds: FactKind, by: By = CELL) -> None:
        self.do(ask.RecordFacts(tuple(self.fact(offer, kind) for kind in kinds)), by)

    def fact(self, offer: Offer, kind: FactKind) -> RunFact:
        self.now += timedelta(seconds=1)
        values = {"read_back_sha256": offer.run.sent_sha256} if kind is FactKind.VERIFIED else {}
        return RunFact(offer.run.key, kind, self.now, "cell", values)

    def run(self) -> Offer:
        """The next block, run whole."""
        offer = self.next()
        assert offer is not None
        self.tell(offer, FactKind.SENT, FactKind.VERIFIED, FactKind.STARTED, FactKind.ENDED)
        if offer.block.kind is BlockKind.PROBE:
            self.do(ask.RecordTouches(offer.run.key, "touches.csv", touches_of(offer)), CELL)
        return offer

    def correct(self, probe: Offer, serial: str | None = None, payload: Any = None) -> str:
        """What a correction from the touches of a gauging run comes to: its program's hash."""
        part = self.part_of(probe)
        text, made = corrected(probe, serial or probe.run.part.serial)
        made = replace(made, payload=payload)
        keep(self.store, [ProgramText(sha256(text).hexdigest(), text), made])
        sha = sha256(text).hexdigest()
        touches = sha256(touches_of(probe)).hexdigest()
        self.do(ask.StepCorrected(self.order, part, 2, probe.run.key, made.record.id, sha, touches), SERVICE)
        return sha

    def part_of(self, offer: Offer) -> int:
        return next(one.row for one in self.now_is().parts if one.value == offer.run.part)


def keep_programs(store: Store) -> None:
    for name, text in TEXTS.items():
        keep(store, [Program(f"{name}.ngc", "linuxcnc", SHA[name], "mm"), ProgramText(SHA[name], text)])


def touches_of(offer: Offer) -> bytes:
    return f"touches of {offer.run.key}".encode()


def corrected(probe: Offer, serial: str) -> tuple[bytes, Correction[Any]]:
    """A corrected finish program and its record, made from the touches of this run, as of a part."""
    name = f"c{sha256(probe.run.key.encode()).hexdigest()[:12]}"
    part_type = PartType("shaft", "B")
    seen = Inspection(Part(part_type, serial), "touches", sha256(touches_of(probe)).hexdigest(), 1)
    record = Record(
        *(name, AT.isoformat(), "service", "0", {"touches.csv": seen.sha256}, {}, {}, ["corrected"], []),
        product=Product.TURNED,
        inspections=(seen,),
        program=Program("finish.ngc", "linuxcnc", SHA["finish"], "mm"),
    )
    text = TEXTS["finish"].replace(b"X1", b"X0.99") + f"(trueloop corrected {name})\n".encode()
    return text, Correction(replace(record, part_type=part_type), {"size_mm": 0.15}, None)
