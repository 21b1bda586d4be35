"""A machine that has started a cut and is not heard any more."""

from datetime import timedelta

from tests.support.factory import CELL, Shop
from trueloop.domain.factory import FactKind, PartState, StepState
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import hold_silent
from trueloop.factory.shown.machines import heard
from trueloop.storage.store import Store

LIMIT_S = 60.0


def test_a_silent_machine_holds_its_part_once_and_a_late_end_frees_it(store: Store) -> None:
    shop = Shop(store).set_up()
    offer = shop.next()
    assert offer is not None
    shop.tell(offer, FactKind.SENT, FactKind.VERIFIED, FactKind.STARTED)
    begun = shop.now
    heard(store, "lathe", {"state": "running"}, CELL, begun + timedelta(seconds=50))
    assert hold_silent(store, begun + timedelta(seconds=105), LIMIT_S) == 0
    assert hold_silent(store, begun + timedelta(seconds=111), LIMIT_S) == 1
    assert hold_silent(store, begun + timedelta(seconds=500), LIMIT_S) == 0
    part = shop.now_is().parts[0]
    assert (part.state, part.steps[0].state) == (PartState.HELD, StepState.UNKNOWN)
    assert "silent for 61 s" in part.held_why
    shop.tell(offer, FactKind.ENDED)
    assert shop.now_is().parts[0].steps[0].state is StepState.RECORDED
    assert shop.now_is().parts[0].state is PartState.SEMIFINISHED


def test_one_that_was_heard_meanwhile_is_not_held(store: Store) -> None:
    shop = Shop(store).set_up()
    offer = shop.next()
    assert offer is not None
    shop.tell(offer, FactKind.STARTED)
    row, late = shop.part_of(offer), shop.now + timedelta(seconds=100)
    heard(store, "lathe", {"state": "running"}, CELL, late)
    from tests.support.factory import SERVICE

    shop.now = late
    shop.do(ask.CellSilent(shop.order, row, 0, LIMIT_S), SERVICE)
    assert shop.now_is().parts[0].steps[0].state is StepState.STARTED


def test_a_machine_that_has_not_started_may_be_silent(store: Store) -> None:
    shop = Shop(store).set_up()
    offer = shop.next()
    assert offer is not None
    shop.tell(offer, FactKind.SENT, FactKind.VERIFIED)
    assert hold_silent(store, shop.now + timedelta(days=1), LIMIT_S) == 0
