"""An order carried out on a real store: each step once, each refusal before anything is written."""

from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from hashlib import sha256

import pytest

from tests.support.factory import (
    BLOCKS,
    CELL,
    ENGINEER,
    OPERATOR,
    PLAN,
    SERVICE,
    SHA,
    VIEWER,
    Shop,
    corrected,
    touches_of,
)
from trueloop.domain.factory import BlockKind, Conditions, FactKind, PartState, Run, RunFact, StepState, WorkOrder
from trueloop.domain.record import ProgramText
from trueloop.errors import Code, TrueloopError
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.requests import By, Role
from trueloop.server.identity.keys import NewKey, add_key
from trueloop.storage.store import Store, find, keep


@pytest.fixture
def shop(store: Store) -> Shop:
    return Shop(store).set_up()


def refused(code: Code, do: Callable[[], object]) -> TrueloopError:
    with pytest.raises(TrueloopError) as found:
        do()
    assert found.value.code is code, str(found.value)
    return found.value


def states(shop: Shop, k: int = 0) -> tuple[PartState, list[StepState]]:
    part = shop.now_is().parts[k]
    return part.state, [one.state for one in part.steps]


def test_a_part_goes_through_all_its_steps(shop: Shop) -> None:
    semi = shop.run()
    assert (semi.block, semi.run.part.serial, semi.mode) == (BLOCKS[0], "a", "press-cycle-start")
    assert states(shop)[0] is PartState.SEMIFINISHED
    probe = shop.run()
    assert states(shop)[0] is PartState.PROBED
    assert shop.next() is None  # the correction is being made
    sha = shop.correct(probe)
    finish = shop.run()
    assert (finish.block.kind, finish.run.program_sha256) == (BlockKind.FINISH, sha)
    assert b"X0.99" in finish.program
    assert shop.next() is None  # the part is in the machine
    row = shop.part_of(finish)
    shop.do(ask.RecordStep(shop.order, row, 4, "out"), OPERATOR)
    refused(Code.FAC_ROLE, lambda: shop.do(ask.RecordStep(shop.order, row, 5, "good"), OPERATOR))
    shop.do(ask.RecordStep(shop.order, row, 5, "good"), ENGINEER)
    assert states(shop)[0] is PartState.RELEASED
    second = shop.run()
    assert second.run.part.serial == "b"
    assert shop.now_is().state == "running"


def test_asked_twice_it_is_the_same_run(shop: Shop) -> None:
    first, again = shop.next(), shop.next()
    assert first is not None
    assert again == first
    assert len(find(shop.store, Run)) == 1


def test_a_cut_that_started_and_did_not_end_is_held_and_not_offered_again(shop: Shop) -> None:
    offer = shop.next()
    assert offer is not None
    shop.tell(offer, FactKind.SENT, FactKind.VERIFIED, FactKind.STARTED)
    assert shop.next() is None
    state, steps = states(shop)
    assert (state, steps[0]) == (PartState.HELD, StepState.UNKNOWN)
    assert shop.next() is None
    row = shop.part_of(offer)
    shop.do(ask.DecideStep(shop.order, row, 0, "made", "looked at it"), OPERATOR)
    assert states(shop)[0] is PartState.SEMIFINISHED
    assert shop.run().block.kind is BlockKind.PROBE


def test_an_end_that_arrives_late_resolves_what_was_unknown(shop: Shop) -> None:
    offer = shop.next()
    assert offer is not None
    ended = shop.fact(offer, FactKind.ENDED)
    shop.tell(offer, FactKind.VERIFIED, FactKind.STARTED, FactKind.UNKNOWN)
    assert states(shop)[0] is PartState.HELD
    shop.do(ask.RecordFacts((ended,)), CELL)
    assert states(shop) == (PartState.SEMIFINISHED, [StepState.RECORDED, *[StepState.WAITING] * 5])


def test_a_cut_decided_as_not_made_that_ran_after_all_holds_the_part(shop: Shop) -> None:
    offer = shop.next()
    assert offer is not None
    shop.tell(offer, FactKind.STARTED, FactKind.UNKNOWN)
    shop.do(ask.DecideStep(shop.order, shop.part_of(offer), 0, "not-made", "the blank is untouched"), OPERATOR)
    again = shop.next()
    assert again is not None
    assert again.run.key != offer.run.key
    shop.tell(offer, FactKind.ENDED)
    assert states(shop)[0] is PartState.HELD
    assert shop.next() is None


def test_a_step_that_a_machine_reports_is_not_recorded_by_hand(shop: Shop) -> None:
    offer = shop.next()
    assert offer is not None
    row = shop.part_of(offer)
    said = refused(Code.FAC_STATE, lambda: shop.do(ask.RecordStep(shop.order, row, 0, "done"), OPERATOR))
    assert "at step 0 (semifinish), which is not recorded by hand: remove and measure and release are" in said.message


def test_what_runs_is_not_decided_over(shop: Shop) -> None:
    offer = shop.next()
    assert offer is not None
    row = shop.part_of(offer)
    shop.tell(offer, FactKind.STARTED)
    refused(Code.FAC_STATE, lambda: shop.do(ask.DecideStep(shop.order, row, 0, "not-made", "x"), OPERATOR))
    shop.do(ask.Hold(shop.order, row, "noise"), OPERATOR)
    refused(Code.FAC_STATE, lambda: shop.do(ask.DecideStep(shop.order, row, 0, "not-made", "x"), OPERATOR))


def test_a_run_that_a_cell_may_still_begin_keeps_its_key(shop: Shop) -> None:
    offer = shop.next()
    assert offer is not None
    row = shop.part_of(offer)
    shop.do(ask.Hold(shop.order, row, "wait"), OPERATOR)
    assert shop.next() is None
    shop.do(ask.DecideStep(shop.order, row, 0, "not-made", "go on"), OPERATOR)
    again = shop.next()
    assert again is not None
    assert again.run.key == offer.run.key


def test_what_was_read_back_otherwise_holds_the_part(shop: Shop) -> None:
    offer = shop.next()
    assert offer is not None
    wrong = replace(shop.fact(offer, FactKind.VERIFIED), values={"read_back_sha256": "0" * 64})
    shop.do(ask.RecordFacts((wrong,)), CELL)
    state, steps = states(shop)
    assert (state, steps[0]) == (PartState.HELD, StepState.OFFERED)
    assert shop.now_is().parts[0].held_why.startswith(Code.FAC_READBACK)


def at_finish(shop: Shop) -> Shop:
    shop.run()
    shop.correct(shop.run())
    return shop


def test_a_finish_cut_that_nobody_read_back_holds_the_part(shop: Shop) -> None:
    offer = at_finish(shop).next()
    assert offer is not None
    shop.tell(offer, FactKind.SENT, FactKind.STARTED, FactKind.ENDED)
    state, steps = states(shop)
    assert (state, steps[3]) == (PartState.HELD, StepState.RECORDED)


def test_before_a_finish_cut_temperatures_and_calibration_are_fresh(shop: Shop) -> None:
    at_finish(shop).now += timedelta(minutes=31)
    refused(Code.FAC_TEMPERATURE, shop.next)
    shop.now += timedelta(days=1)
    shop.warm()
    refused(Code.FAC_CALIBRATION, shop.next)
    shop.do(ask.Calibrated("lathe"), CELL)
    assert shop.next() is not None


def test_a_clock_set_back_makes_nothing_fresh(shop: Shop) -> None:
    at_finish(shop).now -= timedelta(minutes=10)
    refused(Code.FAC_CALIBRATION, shop.next)


def test_an_open_alarm_blocks_the_finish_cut_of_its_machine(shop: Shop) -> None:
    at_finish(shop)
    shop.do(ask.RaiseAlarm("monitor", "MON-ALARM", "out of control", machine="mill", blocks=True), SERVICE)
    shop.do(ask.RaiseAlarm("monitor", "MON-ALARM", "out of control", part_type="shaft", blocks=True), SERVICE)
    assert refused(Code.FAC_ALARM, shop.next).values["alarm"] == 2.0
    shop.do(ask.Acknowledge(2, "tool changed"), OPERATOR)
    refused(Code.FAC_STALE, lambda: shop.do(ask.Acknowledge(2, "tool changed"), OPERATOR))
    assert shop.next() is not None


def test_the_corrector_is_as_planned(store: Store) -> None:
    shop = Shop(store).set_up(replace(PLAN, conditions=Conditions(None, None, "f" * 64)))
    refused(Code.FAC_CORRECTOR, at_finish(shop).next)


def test_touches_of_another_part_are_refused(shop: Shop) -> None:
    shop.run()
    probe = shop.run()
    shop.correct(probe, serial="b")
    refused(Code.FAC_TOUCHES, shop.next)


def test_a_step_without_correction_record_is_refused(shop: Shop) -> None:
    shop.run()
    probe = shop.run()
    said = (probe.run.key, "nothing", SHA["rough"], "")
    shop.do(ask.StepCorrected(shop.order, shop.part_of(probe), 2, *said), SERVICE)
    refused(Code.FAC_PROGRAM, shop.next)


def test_a_program_that_is_not_the_one_its_correction_made_is_refused(shop: Shop) -> None:
    """The correction is this part's own and leads from the order's program; the program accepted is another one."""
    shop.run()
    probe = shop.run()
    text, made = corrected(probe, probe.run.part.serial)
    keep(shop.store, [ProgramText(sha256(text).hexdigest(), text), made])
    other = (probe.run.key, made.record.id, SHA["rough"], sha256(touches_of(probe)).hexdigest())
    shop.do(ask.StepCorrected(shop.order, shop.part_of(probe), 2, *other), SERVICE)
    said = refused(Code.FAC_PROGRAM, shop.next)
    assert SHA["rough"] == said.values["accepted"]
    assert "no correction in the store leads from" in said.message


def test_touches_belong_to_a_gauging_run_and_are_sent_once(shop: Shop) -> None:
    semi = shop.run()
    refused(Code.FAC_TOUCHES, lambda: shop.do(ask.RecordTouches(semi.run.key, "t.csv", b"1"), CELL))
    probe = shop.next()
    assert probe is not None
    shop.do(ask.RecordTouches(probe.run.key, "t.csv", b"1"), CELL)
    shop.do(ask.RecordTouches(probe.run.key, "t.csv", b"1"), CELL)
    refused(Code.FAC_TOUCHES, lambda: shop.do(ask.RecordTouches(probe.run.key, "t.csv", b"2"), CELL))
    shop.tell(probe, FactKind.STARTED, FactKind.ENDED)
    assert states(shop)[0] is PartState.PROBED


def test_a_refused_correction_holds_the_part(shop: Shop) -> None:
    shop.run()
    probe = shop.run()
    row = shop.part_of(probe)
    said = (probe.run.key, "CMP-SIZE", "160.0 µm; the limit is 150.0 µm")
    shop.do(ask.CorrectionRefused(shop.order, row, 2, *said), SERVICE)
    part = shop.now_is().parts[0]
    assert (part.state, part.held_why) == (PartState.HELD, "CMP-SIZE: 160.0 µm; the limit is 150.0 µm")
    assert shop.next() is None
    shop.do(ask.DecideStep(shop.order, row, 2, "not-made", "touch 7 was a chip: correct again"), OPERATOR)
    assert states(shop)[0] is PartState.PROBED


def test_a_part_with_a_chip_on_it_is_probed_again_and_cut_by_the_new_touches(shop: Shop) -> None:
    shop.run()
    first = shop.run()
    row = shop.part_of(first)
    refused(Code.FAC_STATE, lambda: shop.do(ask.DecideStep(shop.order, row, 1, "not-made", "not held"), OPERATOR))
    scatters = ask.CorrectionRefused(shop.order, row, 2, first.run.key, "CMP-SCATTER", "15 µm; the limit is 10 µm")
    shop.do(scatters, SERVICE)
    refused(Code.FAC_STATE, lambda: shop.do(ask.DecideStep(shop.order, row, 1, "made", "x"), OPERATOR))
    refused(Code.FAC_STATE, lambda: shop.do(ask.DecideStep(shop.order, row, 0, "not-made", "a cut"), OPERATOR))
    shop.do(ask.DecideStep(shop.order, row, 1, "not-made", "a chip lay there"), OPERATOR)
    told = tuple(one.value for one in find(shop.store, RunFact) if one.value.run == first.run.key)
    shop.do(ask.RecordFacts(told), CELL)  # its cell tells it again
    assert states(shop)[0] is PartState.SEMIFINISHED
    again = shop.run()
    assert (again.block.kind, again.run.attempt) == (BlockKind.PROBE, 2)
    shop.correct(first)  # by a worker that took its time
    shop.do(scatters, SERVICE)
    assert (states(shop)[0], shop.next()) == (PartState.PROBED, None)


def test_an_order_is_armed_at_its_machine_for_parts_that_are_left(shop: Shop) -> None:
    refused(Code.FAC_ARM, lambda: shop.do(ask.Arm(shop.order, 2, "night"), OPERATOR))
    refused(Code.FAC_ARM, lambda: shop.do(ask.Arm(shop.order, 3, "night"), CELL))
    refused(Code.FAC_ARM, lambda: shop.do(ask.Arm(shop.order, 1, "x"), By("cell", Role.CELL, "mill")))
    shop.do(ask.Arm(shop.order, 1, "night"), CELL)
    at_finish(shop)
    assert shop.run().mode == "armed"
    assert shop.now_is().armed_parts == 0
    shop.do(ask.Arm(shop.order, 1, "night"), CELL)
    shop.do(ask.Hold(shop.order, shop.now_is().parts[1].row, "look"), OPERATOR)
    assert shop.now_is().armed_parts == 0


def test_a_stale_version_is_refused(shop: Shop) -> None:
    row, version = shop.now_is().parts[0].row, str(shop.now_is().version)
    shop.do(ask.Hold(shop.order, row, "first"), OPERATOR, version)
    late = refused(Code.FAC_STALE, lambda: shop.do(ask.Hold(shop.order, row, "second"), OPERATOR, version))
    assert late.values == {"expected": version, "found": str(shop.now_is().version)}
    assert shop.now_is().parts[0].held_why.endswith("otto: first")


def test_roles_and_machines(shop: Shop) -> None:
    for by in (VIEWER, OPERATOR, CELL, SERVICE):
        refused(Code.FAC_ROLE, lambda by=by: shop.do(PLAN, by))  # type: ignore[misc]
    refused(Code.FAC_ROLE, lambda: shop.do(ask.NextBlock("lathe"), ENGINEER))
    refused(Code.FAC_MACHINE, lambda: shop.do(ask.NextBlock("mill"), CELL))
    offer = shop.next()
    assert offer is not None
    mill = By("cell", Role.CELL, "mill")
    refused(Code.FAC_MACHINE, lambda: shop.tell(offer, FactKind.STARTED, by=mill))
    assert find(shop.store, RunFact) == []


def test_a_refused_request_leaves_nothing_behind(shop: Shop) -> None:
    offer = shop.next()
    assert offer is not None
    good, unknown = shop.fact(offer, FactKind.STARTED), RunFact("no such run", FactKind.STARTED, shop.now, "cell")
    refused(Code.FAC_UNKNOWN, lambda: shop.do(ask.RecordFacts((good, unknown)), CELL))
    assert find(shop.store, RunFact) == []


def test_a_part_is_ordered_once_and_programs_are_released_first(shop: Shop) -> None:
    assert refused(Code.FAC_ORDERED, lambda: shop.do(replace(PLAN, serials=("c", "b")))).values == {"serial": "b"}
    odd = replace(PLAN, serials=("d",), blocks=(replace(BLOCKS[0], program_sha256="9" * 64), *BLOCKS[1:]))
    refused(Code.FAC_RELEASE, lambda: shop.do(odd))
    for blocks in (
        (),
        BLOCKS[::-1],
        BLOCKS[2:],
        (replace(BLOCKS[0], corrected=True),),
        (BLOCKS[4], BLOCKS[5], BLOCKS[5]),
    ):
        refused(Code.FAC_PLAN, lambda blocks=blocks: shop.do(replace(PLAN, serials=("d",), blocks=blocks)))  # type: ignore[misc]


def test_events_and_tasks_come_with_their_cause(shop: Shop) -> None:
    shop.run()
    shop.run()
    with shop.store.reading() as connection:
        said = connection.exec_driver_sql("SELECT what, who FROM event ORDER BY id").all()
        tasks = connection.exec_driver_sql("SELECT kind, state, document FROM task").all()
    assert [tuple(one) for one in said][-2:] == [("touches", "cell"), ("recorded", "cell")]
    assert [tuple(one)[:2] for one in tasks] == [("correct", "waiting")]


def test_nothing_is_done_for_a_machine_without_orders(store: Store) -> None:
    assert carry_out(store, ask.NextBlock("lathe"), CELL, Shop(store).now).answer is None


def test_a_machine_that_the_store_does_not_know_is_refused_unless_it_is_stated_to_be_new(shop: Shop) -> None:
    mistyped = replace(PLAN, serials=("d",), machine="lahte", new_machine=False)
    refusal = refused(Code.FAC_PLAN, lambda: shop.do(mistyped))
    assert "'lahte'" in refusal.message and "'lathe'" in refusal.hint
    assert len(find(shop.store, WorkOrder)) == 1
    add_key(shop.store, NewKey("mill", "cell of mill", 30), "ana", shop.now)
    for known in (replace(mistyped, machine="mill"), replace(mistyped, serials=("e",), new_machine=True)):
        assert carry_out(shop.store, known, ENGINEER, shop.now).orders[0].order.machine.name == known.machine
