"""A shop that has something of everything to show, with names that are scripts where names may be anything."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from hashlib import sha256

from tests.support.correction import example_correction
from tests.support.factory import CELL, ENGINEER, OPERATOR, PLAN, SERVICE, SHA, TEXTS, Shop
from tests.support.kept import EDGE, MADE_AT, SET_AT, TYPE, cut_of, inspected, of_part
from tests.support.series import inspection, reading
from trueloop.domain.factory import FactKind
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, EdgeEvent, EdgeEventKind, Stage
from trueloop.domain.part import Part, PartType
from trueloop.domain.proposal import Effect, Proposal, ProposalClass, ProposalDecision
from trueloop.domain.record import Program, ProgramText
from trueloop.domain.tool import Setting
from trueloop.factory import requests as ask
from trueloop.factory.book import read_book
from trueloop.factory.carry_out import carry_out
from trueloop.factory.requests import By, Role
from trueloop.factory.shown.machines import heard
from trueloop.loops.post_process.propose import ProposalContext, proposals_of
from trueloop.loops.post_process.series import SeriesOptions
from trueloop.loops.turned.provenance import enveloped
from trueloop.storage.store import Store, keep

SCRIPT = "<img src=x onerror=alert(1)><script>alert(2)</script>"
REPORT = b"<!doctype html><html lang='en'><title>Certificate</title><h1>Certificate of part a</h1><p>in tolerance</p>"


def full_shop(store: Store) -> Shop:
    """Part a is corrected, cut and measured; part b is held in a cut that nobody saw end."""
    shop = Shop(store, datetime.now(UTC) - timedelta(minutes=10)).set_up(replace(PLAN, serials=("a", "b")))
    shop.run()
    shop.correct(shop.run(), payload=example_correction("modbas2"))
    finished = shop.part_of(shop.run())
    shop.do(ask.RecordStep(shop.order, finished, 4, "out of the chuck"), OPERATOR)
    begun = shop.next()
    assert begun is not None
    shop.tell(begun, FactKind.SENT, FactKind.VERIFIED, FactKind.STARTED, FactKind.UNKNOWN)
    measured = Inspection(
        Part(PartType("shaft", "B"), "a"),
        *("readings", sha256(b"cmm").hexdigest(), 3),
        (reading("dome", 4.2), reading("journal", -7.9), reading("collar", 41.0)),
        device="CMM 1",
        measured_at=shop.now,
    )
    keep(store, [measured])
    shop.do(ask.Certify(finished, REPORT, "in"), ENGINEER)
    shop.do(ask.RecordTransfer("lathe", SHA["finish"], "O1.nc", "to", SHA["finish"], SHA["finish"], "sent"), OPERATOR)
    shop.do(ask.RaiseAlarm("monitor", "MON-ALARM", "out of control: 2 of 3 beyond 2 σ", {"rule": "2"}), SERVICE)
    _scripts(shop)
    _edge(shop)
    _series(shop)
    _heard(shop)
    return shop


def _scripts(shop: Shop) -> None:
    """Names that people, files and controls may choose."""
    text = TEXTS["finish"] + f"({SCRIPT})\n".encode()
    name = sha256(text).hexdigest()
    keep(shop.store, [Program(SCRIPT, "linuxcnc", name, "mm"), ProgramText(name, text)])
    plan = replace(PLAN, machine=SCRIPT, serials=(SCRIPT,), part_type=SCRIPT)
    order = carry_out(shop.store, plan, ENGINEER, shop.now).orders[0]
    shop.do(ask.Hold(order.order.id, order.parts[0].row, SCRIPT), OPERATOR)
    shop.do(ask.RaiseAlarm(SCRIPT, "MON-ALARM", SCRIPT, {SCRIPT: SCRIPT}, machine=SCRIPT), SERVICE)


def _edge(shop: Shop) -> None:
    """Three parts with a dome, cut with one edge and inspected."""
    keep(shop.store, [EdgeEvent(EDGE, EdgeEventKind.MOUNTED, SET_AT)])
    for order, serial in enumerate(("2511", "2611", "2711")):
        correction = of_part(example_correction("modbas2"), serial)
        cut = cut_of(correction, serial, order=order)
        keep(shop.store, [enveloped(correction), cut, *inspected(correction, cut, 1.0 + order)])
    effect = Effect("dome", ("MODBAS2", "B", "dome"), 3, -0.008, 0.009, 0.001, 0.0005)
    made = Proposal("dome1", ProposalClass.MEMORY, TYPE, (effect,), "2711", shop.now, "ana", from_serial="2711")
    keep(shop.store, [made, ProposalDecision("dome1", "rejected", "ana", shop.now, "the edge was turned")])


def _series(shop: Shop) -> None:
    """A journal that is some 12 µm too large, the tool set anew before part 504, and what that proposes;
    a seat whose last part is far off.
    """
    first = shop.now - timedelta(hours=30)
    errors = (9.0, 14.0, 12.5, 11.0, 13.0, 12.0, 15.5, 10.5, 12.0, 13.5)
    seats = (0.2, 1.0, -1.0, 0.5, -0.5, 0.2, 1.0, -1.0, -0.2, 27.0)
    both = enumerate(zip(errors, seats, strict=True))
    seen = [inspection(f"{500 + k}", {"journal": error, "seat": seat}) for k, (error, seat) in both]
    keep(shop.store, [replace(one, measured_at=first + timedelta(hours=k)) for k, one in enumerate(seen)])
    settings = Setting(EDGE, SET_AT), Setting(EDGE, MADE_AT)
    keep(shop.store, [Cut(one.part, Stage.FINISH, settings[k >= 4], order=10 + k) for k, one in enumerate(seen)])
    book = read_book(shop.store, "SHAFT", SeriesOptions())
    keep(shop.store, list(proposals_of(book.tracked, SeriesOptions(), ProposalContext("ana", shop.now)))[:1])


def _heard(shop: Shop) -> None:
    """What cells and people say of machines: the lathe's of a shift, the mill's of four minutes ago."""
    shop.do(ask.Calibrated("lathe", {"radius_mm": "0.9987"}), OPERATOR)
    for k in range(40):
        warm = {"spindle": 21.0 + 0.1 * k, "bed": 20.0 + 0.01 * k}
        shop.do(ask.RecordTemperatures("lathe", warm, datetime.now(UTC) - timedelta(minutes=10 * (39 - k))), CELL)
    said = {"state": "running", "line": 420, "progress": 0.7, "program": "finish.ngc", "corrector": "on"}
    told = {**said, "temperatures_c": {"spindle": 23.5, "bed": 21.0}}
    heard(shop.store, "lathe", told, CELL, datetime.now(UTC))
    silent = datetime.now(UTC) - timedelta(minutes=4)
    heard(shop.store, "mill", {"state": "idle", "program": "face.ngc"}, By("cell", Role.CELL, "mill"), silent)
