"""Every way in which the factory refuses."""

from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from hashlib import sha256

from tests.support.factory import CELL, OPERATOR, PLAN, SERVICE, VIEWER, Shop
from trueloop.domain.factory import Conditions, FactKind
from trueloop.errors import Code, TrueloopError
from trueloop.factory import requests as ask
from trueloop.factory.requests import By, Role
from trueloop.storage.store import open_store


def _shop(plan: ask.PlanOrder = PLAN) -> Shop:
    return Shop(open_store("sqlite://", create=True)).set_up(plan)


def _row(shop: Shop) -> int:
    return shop.now_is().parts[0].row


def _at_finish(plan: ask.PlanOrder = PLAN, serial: str | None = None) -> Shop:
    shop = _shop(plan)
    shop.run()
    shop.correct(shop.run(), serial)
    return shop


def _stale() -> None:
    shop = _shop()
    shop.do(ask.Hold(shop.order, _row(shop), "look"), OPERATOR)
    shop.do(ask.Hold(shop.order, _row(shop), "look"), OPERATOR, "1")


def _too_far() -> None:
    shop = _shop()
    shop.do(ask.RecordStep(shop.order, _row(shop), 4, "out"), OPERATOR)


def _held() -> None:
    shop = _shop()
    shop.do(ask.Hold(shop.order, _row(shop), "look"), OPERATOR)
    shop.do(ask.RecordStep(shop.order, _row(shop), 4, "out"), OPERATOR)


def _why_held(facts: Callable[[Shop], None]) -> TrueloopError:
    """What holds a part has the code of why: it is refused with it as one records the next step."""
    shop = _shop()
    facts(shop)
    held = shop.now_is().parts[0]
    code, _, why = held.held_why.partition(": ")
    return TrueloopError(Code(code), why, hint="decide on it first")


def _unknown_cut() -> None:
    def facts(shop: Shop) -> None:
        offer = shop.next()
        assert offer is not None
        shop.tell(offer, FactKind.STARTED, FactKind.UNKNOWN)

    raise _why_held(facts)


def _read_back() -> None:
    def facts(shop: Shop) -> None:
        offer = shop.next()
        assert offer is not None
        wrong = replace(shop.fact(offer, FactKind.VERIFIED), values={"read_back_sha256": sha256(b"other").hexdigest()})
        shop.do(ask.RecordFacts((wrong,)), CELL)

    raise _why_held(facts)


def _program() -> None:
    shop = _shop()
    shop.run()
    probe = shop.run().run.key
    shop.do(ask.StepCorrected(shop.order, _row(shop), 2, probe, "0123456789abcdef", "9" * 64, ""), SERVICE)
    shop.next()


def _cold() -> None:
    shop = _at_finish()
    shop.now += timedelta(minutes=45)
    shop.next()


def _uncalibrated() -> None:
    shop = _at_finish()
    shop.now += timedelta(hours=30)
    shop.next()


def _alarm() -> None:
    shop = _at_finish()
    shop.do(ask.RaiseAlarm("monitor", "MON-ALARM", "out of control", machine="lathe", blocks=True), SERVICE)
    shop.next()


def _corrector() -> None:
    _at_finish(replace(PLAN, conditions=Conditions(None, None, "a1b2" * 16))).next()


def _asked(request: ask.Request, by: By) -> Callable[[], None]:
    def ask_it() -> None:
        _shop().do(request, by)

    return ask_it


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.FAC_UNKNOWN: _asked(ask.Hold("O17", 1, "look"), OPERATOR),
    Code.FAC_ROLE: _asked(PLAN, VIEWER),
    Code.FAC_MACHINE: _asked(ask.NextBlock("mill"), CELL),
    Code.FAC_STALE: _stale,
    Code.FAC_PLAN: _asked(replace(PLAN, serials=("c",), blocks=PLAN.blocks[::-1]), By("ana", Role.ENGINEER)),
    Code.FAC_ORDERED: _asked(PLAN, By("ana", Role.ENGINEER)),
    Code.FAC_RELEASE: _asked(ask.RecordTransfer("lathe", "9" * 64, "O1.nc", "to", "", "", ""), OPERATOR),
    Code.FAC_STATE: _too_far,
    Code.FAC_CUT: _unknown_cut,
    Code.FAC_HELD: _held,
    Code.FAC_ARM: _asked(ask.Arm("O1", 2, "night"), OPERATOR),
    Code.FAC_PROGRAM: _program,
    Code.FAC_READBACK: _read_back,
    Code.FAC_TOUCHES: lambda: _at_finish(serial="b").next(),
    Code.FAC_CALIBRATION: _uncalibrated,
    Code.FAC_TEMPERATURE: _cold,
    Code.FAC_CORRECTOR: _corrector,
    Code.FAC_ALARM: _alarm,
}
