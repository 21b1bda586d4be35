"""What is shown is what the store holds; lists are paged without loss; two who accept at once are told apart."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import timedelta
from hashlib import sha256

import pytest
from sqlalchemy import insert

from tests.support.correction import example_correction
from tests.support.factory import BLOCKS, CELL, ENGINEER, OPERATOR, PLAN, SERVICE, SHA, Shop
from tests.support.kept import EDGE, MADE_AT, SET_AT, of_part
from tests.support.series import inspection
from trueloop.domain.factory import BlockKind, FactKind, PartState, StepState
from trueloop.domain.inspection import CmmPoint, Inspection
from trueloop.domain.life import Cut, InspectionLink, Stage, edge_name
from trueloop.domain.part import Part, PartType
from trueloop.domain.proposal import Proposal, ToolOffset
from trueloop.domain.record import Correction, ProgramText
from trueloop.domain.tool import Setting
from trueloop.errors import Code, TrueloopError
from trueloop.factory import requests as ask
from trueloop.factory.book import read_book
from trueloop.factory.carry_out import carry_out
from trueloop.factory.shown.machines import heard, machine_view, machines_now, tool_rows
from trueloop.factory.shown.orders import order_rows, order_view, today
from trueloop.factory.shown.parts import part_life, part_rows
from trueloop.factory.shown.programs import program_diff, program_rows, proposal_view, proposal_views, text_of
from trueloop.factory.shown.records import (
    alarm_rows,
    certificate_content,
    certificate_rows,
    event_rows,
    events_after,
    known_of,
    transfer_rows,
)
from trueloop.factory.shown.series import series_rows, series_view
from trueloop.factory.views.orders import CorrectedFrom
from trueloop.loops.post_process.propose import ProposalContext, proposals_of
from trueloop.loops.post_process.series import SeriesOptions
from trueloop.report.texts.texts import Texts
from trueloop.storage.schema import TEMPERATURE, stamp
from trueloop.storage.store import Store, keep, open_store


@pytest.fixture
def shop(store: Store) -> Shop:
    return Shop(store).set_up()


def test_a_life_has_every_step_with_its_facts(shop: Shop) -> None:
    semi = shop.run()
    shop.correct(shop.run())
    row = shop.part_of(semi)
    shown = part_life(shop.store, row)
    assert (shown.part.serial, shown.part.state, shown.part.order) == ("a", PartState.CORRECTED, shop.order)
    assert [one.state for one in shown.steps[:4]] == [StepState.RECORDED] * 3 + [StepState.WAITING]
    kinds = [FactKind.SENT, FactKind.VERIFIED, FactKind.STARTED, FactKind.ENDED]
    assert [one.what for one in shown.steps[0].facts] == kinds
    assert (shown.steps[0].run, shown.steps[0].sent_sha256) == (semi.run.key, semi.run.sent_sha256)
    (made,) = shown.corrections
    assert (made.id, made.source_sha256) == (shown.steps[2].run, SHA["finish"])
    assert made.corrected_sha256 == shown.steps[3].program_sha256 != ""
    assert [one.what for one in shown.events] == [
        "offered",
        "recorded",
        "offered",
        "ended",
        "touches",
        "recorded",
        "corrected",
    ]
    assert shown.etag == order_view(shop.store, shop.order).etag


def test_errors_keep_their_sign_and_unit(store: Store) -> None:
    part = Part(PartType("SHAFT"), "7")
    cut = Cut(part, Stage.FINISH)
    seen = inspection("7", {"journal": 12.0, "seat": -31.0}, hours=1)
    keep(store, [seen, cut, InspectionLink(seen.identity, cut.identity)])
    (row,) = part_rows(store, part_type="SHAFT").items
    (shown,) = part_life(store, row.id).inspections
    assert (row.state, shown.stage) == (None, "finish")
    assert [(one.characteristic, round(one.deviation_um or 0, 6), one.verdict) for one in shown.results] == [
        ("journal", 12.0, "in"),
        ("seat", -31.0, "out"),
    ]
    assert shown.rms_um == pytest.approx(((12.0**2 + 31.0**2) / 2) ** 0.5)


def test_points_of_a_measuring_machine_are_counted_as_touches_are(store: Store) -> None:
    part = Part(PartType("SHAFT"), "8")
    points = tuple(CmmPoint((float(k), 0.0, 0.0)) for k in range(7))
    keep(store, [Inspection(part, "CMM points", "a" * 64, len(points), points)])
    (row,) = part_rows(store, part_type="SHAFT").items
    assert [one.touches for one in part_life(store, row.id).inspections] == [7]


def test_pages_hold_every_part_once(store: Store) -> None:
    keep(store, [Part(PartType("t"), str(k)) for k in range(23)])
    found: list[str] = []
    cursor, pages = None, 0
    while True:
        page = part_rows(store, limit=5, cursor=cursor)
        found += [one.serial for one in page.items]
        keep(store, [Part(PartType("later"), str(pages))])  # what is new moves nothing
        pages, cursor = pages + 1, page.next
        if cursor is None:
            break
    assert (found, pages) == ([str(k) for k in reversed(range(23))], 5)
    with pytest.raises(TrueloopError, match="'x' is no cursor"):
        part_rows(store, cursor="x")


def test_parts_by_state_and_serial(shop: Shop) -> None:
    keep(shop.store, [Part(PartType("other"), "a")])
    shop.run()
    assert [one.serial for one in part_rows(shop.store, state=PartState.SEMIFINISHED).items] == ["a"]
    assert [one.part_type for one in part_rows(shop.store, serial="a").items] == ["other", "shaft"]
    assert part_rows(shop.store, state=PartState.HELD).items == ()


def test_orders_count_what_is_finished_and_held(shop: Shop) -> None:
    shop.run()
    shop.correct(shop.run())
    shop.run()
    shop.do(ask.Hold(shop.order, shop.now_is().parts[1].row, "look"), OPERATOR)
    carry_out(shop.store, replace(PLAN, serials=("c",)), ENGINEER, shop.now)
    rows = order_rows(shop.store, limit=1)
    (first,) = rows.items
    (second,) = order_rows(shop.store, limit=1, cursor=rows.next).items
    assert (first.quantity, first.state) == (1, "planned")
    assert (second.id, second.finished, second.held, second.state) == (shop.order, 1, 1, "held")
    view = order_view(shop.store, shop.order)
    assert [one.kind for one in view.blocks] == [one.kind for one in BLOCKS]
    assert view.blocks[0].program == "semifinish.ngc"
    assert [one.state for one in view.parts] == [PartState.FINISHED, PartState.HELD]
    with pytest.raises(TrueloopError, match="no order 'O9'"):
        order_view(shop.store, "O9")


def test_programs_are_shown_and_compared(shop: Shop) -> None:
    shop.run()
    sha = shop.correct(shop.run())
    rows = {one.sha256: one for one in program_rows(shop.store).items}
    assert (rows[SHA["finish"]].name, rows[SHA["finish"]].released) == ("finish.ngc", True)
    made = CorrectedFrom(shop.now_is().parts[0].steps[2].run, "finish.ngc", SHA["finish"], "shaft", "B", "a")
    assert (rows[sha].released, rows[sha].name, rows[sha].corrected) == (False, "", made)
    assert {one.corrected for one in rows.values()} == {None, made}
    found = program_diff(shop.store, SHA["finish"], sha)
    changed = [(one.change, one.text) for one in found.lines if one.change != "same"]
    assert ("before", "G1 X1") in changed
    assert ("after", "G1 X0.99") in changed
    assert found.differences == 2
    assert program_diff(shop.store, sha, sha).differences == 0
    assert text_of(shop.store, sha) != text_of(shop.store, SHA["finish"])
    with pytest.raises(TrueloopError, match="no program '9999"):
        text_of(shop.store, "9" * 64)


def test_a_corrected_program_that_no_order_made_is_known_by_its_mark(store: Store) -> None:
    correction = of_part(example_correction("modbas2"), "2711")
    marked = correction.corrected_program.replace(
        example_correction("modbas2").record.id.encode(), correction.record.id.encode()
    )
    other = marked.replace(correction.record.id.encode(), b"0" * 16)
    keep(
        store,
        [
            Correction(replace(correction.record, options={}), {"size_mm": 0.15}, None),
            *(ProgramText(sha256(one).hexdigest(), one) for one in (marked, other)),
        ],
    )
    unknown, found = program_rows(store).items
    assert unknown.corrected is None
    assert found.corrected is not None
    assert (found.corrected.correction, found.corrected.serial) == (correction.record.id, "2711")
    source = correction.record.program
    assert source is not None
    assert (found.corrected.name, found.corrected.source_sha256) == (source.name, source.sha256)


def test_today_says_what_waits_for_whom(shop: Shop) -> None:
    assert today(shop.store, shop.now).waiting == ()
    offer = shop.next()
    assert offer is not None
    shop.tell(offer, FactKind.SENT, FactKind.VERIFIED)
    assert [(one.action, one.subject, one.id) for one in today(shop.store, shop.now).waiting] == [
        ("start", "order", shop.order)
    ]
    shop.tell(offer, FactKind.STARTED, FactKind.ENDED)
    shop.correct(shop.run())
    row = shop.part_of(shop.run())
    shop.do(ask.RaiseAlarm("monitor", "MON-ALARM", "out of control", machine="lathe"), SERVICE)
    shop.do(ask.Hold(shop.order, shop.now_is().parts[1].row, "burr"), OPERATOR)
    page = today(shop.store, shop.now)
    assert [(one.action, one.part, one.role) for one in page.waiting] == [
        ("decide", "b", "operator"),
        ("remove", "a", "operator"),
        ("acknowledge", "", "operator"),
    ]
    assert page.waiting[0].said == "FAC-HELD: otto: burr"
    assert (page.made.made, page.made.held, page.made.in_tolerance) == (1, 1, 0)
    keep(shop.store, [replace(inspection("a", {"d": 3.0}), part=Part(PartType("shaft", "B"), "a"))])
    assert today(shop.store, shop.now).made.in_tolerance == 1
    shop.do(ask.RecordStep(shop.order, row, 4, "out"), OPERATOR)
    assert ("release", "a", "engineer") in [
        (one.action, one.part, one.role) for one in today(shop.store, shop.now).waiting
    ]
    assert today(shop.store, shop.now + timedelta(days=2)).made.made == 0


def test_a_machine_that_is_silent_is_stale(shop: Shop) -> None:
    (before,) = machines_now(shop.store, shop.now)
    assert (before.name, before.at, before.stale) == ("lathe", None, True)
    offer = shop.next()
    assert offer is not None
    shop.tell(offer, FactKind.STARTED)
    heard(shop.store, "lathe", {"state": "running", "line": 7, "temperatures_c": {"spindle": 23.0}}, CELL, shop.now)
    heard(shop.store, "lathe", {"state": "running", "line": 8, "corrector": "off"}, CELL, shop.now)
    (now,) = machines_now(shop.store, shop.now + timedelta(seconds=9))
    assert (now.stale, now.line, now.part, now.block, now.step_state) == (
        *(False, 8, "a", BlockKind.SEMIFINISH),
        StepState.STARTED,
    )
    assert machine_view(shop.store, "lathe", shop.now + timedelta(seconds=11)).now.stale
    with pytest.raises(TrueloopError) as other:
        heard(shop.store, "mill", {}, CELL, shop.now)
    assert other.value.code is Code.FAC_MACHINE


def test_records_are_listed_newest_first(shop: Shop) -> None:
    shop.do(ask.RecordTransfer("lathe", SHA["finish"], "O1.nc", "to", SHA["finish"], SHA["finish"], "sent"), OPERATOR)
    row = shop.now_is().parts[0].row
    shop.do(ask.Certify(row, b"<html>", "in"), ENGINEER)
    shop.do(ask.RaiseAlarm("m", "MON-ALARM", "first", {"k": "1"}), SERVICE)
    shop.do(ask.RaiseAlarm("m", "MON-ALARM", "second"), SERVICE)
    shop.do(ask.Acknowledge(1, "seen"), OPERATOR)
    assert [(one.control, one.program, one.outcome) for one in transfer_rows(shop.store).items] == [
        ("lathe", "O1.nc", "sent")
    ]
    (certificate,) = certificate_rows(shop.store).items
    assert (certificate.serial, certificate.made_by, certificate_content(shop.store, 1)) == ("a", "ana", b"<html>")
    assert part_life(shop.store, row).certificates == (certificate,)
    assert [one.said for one in alarm_rows(shop.store).items] == ["second", "first"]
    assert [one.said for one in alarm_rows(shop.store, open_only=True).items] == ["second"]
    assert alarm_rows(shop.store).items[1].acknowledged_by == "otto"
    newest = event_rows(shop.store, limit=1).items[0]
    assert newest.what == "acknowledged"
    assert events_after(shop.store, newest.id - 1) == (newest,)
    assert tool_rows(shop.store) == ()


def proposed(shop: Shop) -> str:
    """A series that is 12 µm too large, and what it proposes."""
    keep(shop.store, [inspection(str(k), {"journal": 12.0 + k % 2}, hours=k) for k in range(6)])
    book = read_book(shop.store, "SHAFT", SeriesOptions())
    (one, *_) = proposals_of(book.tracked, SeriesOptions(), ProposalContext("ana", shop.now))
    keep(shop.store, [one])
    return one.id


def test_a_proposal_is_shown_and_accepted_once(shop: Shop) -> None:
    number = proposed(shop)
    (shown,) = proposal_views(shop.store, shop.now, "open")
    assert (shown.id, shown.refusal) == (number, "")
    assert shown.effects[0].size_change_um < 0 < shown.effects[0].error_before_um
    late = proposal_view(shop.store, number, shop.now + timedelta(days=90))
    assert late.refusal.startswith("SER-OLD")
    shop.do(ask.DecideProposal(number, "accepted", "looks right"))
    assert proposal_view(shop.store, number, shop.now).state == "accepted"
    with pytest.raises(TrueloopError) as twice:
        shop.do(ask.DecideProposal(number, "rejected", "no"))
    assert twice.value.code is Code.FAC_STALE


@pytest.mark.parametrize("known_mm", [None, (0.003, None)])
def test_a_proposed_offset_is_shown_with_how_well_it_is_known(
    shop: Shop, known_mm: tuple[float | None, float | None] | None
) -> None:
    number = proposed(shop)
    with known_of(shop.store) as known:
        one = known.first(Proposal, number)
    offset = ToolOffset(3, -0.012, 0.004, True, "diameter", "mm", expanded_u_mm=known_mm)
    keep(shop.store, [replace(one, id="of-a-tool", tool_offset=offset)])
    shown = proposal_view(shop.store, "of-a-tool", shop.now)
    assert (shown.tool, shown.dx_mm, shown.dz_mm) == ("T3", -0.012, 0.004)
    assert (shown.u_stated, shown.dx_u_mm, shown.dz_u_mm) == (known_mm is not None, *(known_mm or (None, None)))


def test_of_two_who_decide_at_once_one_wins(shop: Shop, stored_at: str) -> None:
    number = proposed(shop)

    def decide(verdict: str) -> str:
        store = open_store(stored_at, wait_s=60)
        try:
            request = ask.DecideProposal(number, "accepted" if verdict == "accepted" else "rejected", "at once")
            carry_out(store, request, ENGINEER, shop.now)
        except TrueloopError as refused:
            return refused.code
        finally:
            store.close()
        return verdict

    with ThreadPoolExecutor(4) as pool:
        came = list(pool.map(decide, ["accepted", "rejected", "accepted", "rejected"]))
    won = [one for one in came if one in ("accepted", "rejected")]
    assert len(won) == 1
    assert sorted(set(came) - set(won)) == ["FAC-STALE"]
    assert proposal_view(shop.store, number, shop.now).state == won[0]


def test_a_series_keeps_its_signs(shop: Shop) -> None:
    keep(shop.store, [inspection(str(k), {"journal": -5.0 - k}, hours=k) for k in range(4)])
    (row,) = series_rows(shop.store, "SHAFT")
    assert (row.parts, row.last_serial, round(row.last_deviation_um, 6)) == (4, "3", -8.0)
    view = series_view(shop.store, "SHAFT", "journal")
    assert [round(one.deviation_um, 6) for one in view.points] == [-5.0, -6.0, -7.0, -8.0]
    assert (round(view.lower_um or 0, 6), round(view.upper_um or 0, 6)) == (-30.0, 30.0)


def test_the_next_part_is_expected_by_the_parts_so_far_and_not_as_the_last_one_was(shop: Shop) -> None:
    """After one part at +50 µm most of that is its level: at most 50 · 20² / (20² + 2.5²) = 49.2 µm by the prior of
    turning, and less, since its scatter may be more than 2.5 µm.
    """
    keep(shop.store, [inspection("1", {"journal": 50.0}, hours=0)])
    (row,) = series_rows(shop.store, "SHAFT")
    assert row.expected_um is not None and 40.0 < row.expected_um < 49.2
    assert series_view(shop.store, "SHAFT", "journal").points[0].expected_um == 0.0


def test_a_series_says_which_edge_cut_where_it_was_set_and_why_the_weight_moved(shop: Shop) -> None:
    """From the second part on more is known; a part after a new setting begins anew, and its weight rises."""
    made = [inspection(str(k), {"journal": error}, hours=k) for k, error in enumerate((9, 14, 12, 11, 13, 12, 30, 29))]
    settings = Setting(EDGE, SET_AT), Setting(EDGE, MADE_AT)
    keep(shop.store, [*made, *(Cut(one.part, Stage.FINISH, settings[k >= 6], order=k) for k, one in enumerate(made))])
    view = series_view(shop.store, "SHAFT", "journal")
    assert [one.tool_changed for one in view.points] == [""] * 6 + ["set", ""]
    assert {(one.edge, one.tool) for one in view.points} == {(tool_rows(shop.store)[0].id, edge_name(EDGE))}
    moves = {one.serial: one for one in view.moves}
    assert moves["6"].after > moves["6"].before and 0 < view.weight <= 1
    german = series_view(shop.store, "SHAFT", "journal", say=Texts("de"))
    assert [one.serial for one in german.moves] == list(moves)
    assert all(one.why and one.why != moves[one.serial].why for one in german.moves)


def test_a_capability_is_of_the_parts_since_the_tool_was_set(shop: Shop) -> None:
    """By hand: errors ±1 µm about 5 µm, limits ±30 µm: (30 − 5) / 3 s with s² = 20/19 µm²."""
    keep(shop.store, [inspection(str(k), {"journal": 5.0 + (-1) ** k}, hours=k) for k in range(20)])
    view = series_view(shop.store, "SHAFT", "journal")
    assert view.ppk == pytest.approx(25 / (3 * (20 / 19) ** 0.5), rel=1e-6)
    assert view.ppk is not None and view.ppk_lower is not None and view.ppk_lower < view.ppk
    keep(shop.store, [inspection("20", {"journal": 5.0}, hours=20)])
    early = Setting(EDGE, SET_AT)
    anew = Setting(EDGE, MADE_AT)
    cuts = [inspection(str(k), {"journal": 5.0}).part for k in (19, 20)]
    keep(shop.store, [Cut(cuts[0], Stage.FINISH, early, order=19), Cut(cuts[1], Stage.FINISH, anew, order=20)])
    assert series_view(shop.store, "SHAFT", "journal").ppk is None


def test_of_many_temperatures_the_last_of_each_minute_is_shown(shop: Shop) -> None:
    """1,201 of one sensor, one every 10 s; the other sensors' and the other machine's are not mixed with them."""
    times = [shop.now + timedelta(seconds=10 * k) for k in range(1201)]
    rows = [
        {"machine": machine, "run": "", "signal": "bed", "at": stamp(at), "celsius": sign * k}
        for k, at in enumerate(times)
        for machine, sign in (("lathe", 1), ("mill", -1))
    ]
    with shop.store.writing() as connection:
        connection.execute(insert(TEMPERATURE), rows)
    shop.now = times[-1]
    heard(shop.store, "lathe", {"state": "idle"}, CELL, shop.now)
    shown = {one.signal: one for one in machine_view(shop.store, "lathe", shop.now).temperatures}
    last_of = {at.replace(second=0, microsecond=0): float(k) for k, at in enumerate(times)}
    assert shown["bed"].celsius == tuple(last_of.values()) and len(last_of) in (200, 201)
    assert shown["bed"].at[-1] == shop.now and not shown["bed"].stale
    assert len(shown["spindle"].celsius) == 1
