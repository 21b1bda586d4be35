"""`trueloop tool`: what an edge has taught is shown as it was learnt, and events are kept as they were stated."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke, output_of, run
from tests.support.correction import example_correction
from tests.support.kept import EDGE, MADE_AT, cut_of, inspected, of_part
from trueloop.domain.life import Cut, EdgeEvent, EdgeEventKind
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.history import history_of
from trueloop.loops.turned.provenance import enveloped
from trueloop.memory.edge.learnt import learnt
from trueloop.storage.store import Store, find, keep, open_store

SERIALS = ("2511", "2611", "2711")


@pytest.fixture
def db(tmp_path: Path) -> Path:
    """Three parts of one edge, T1 PCLNL, inspected after the finish cut."""
    file = tmp_path / "trueloop.db"
    store = open_store(file, create=True, codec=store_codec())
    keep(store, [EdgeEvent(EDGE, EdgeEventKind.MOUNTED, MADE_AT)])
    for order, serial in enumerate(SERIALS):
        correction = of_part(example_correction("modbas2"), serial)
        cut = cut_of(correction, serial, order=order)
        keep(store, [enveloped(correction), cut, *inspected(correction, cut, 1.0 + order)])
    return file


def opened(db: Path) -> Store:
    return open_store(db, codec=store_codec())


def test_what_is_shown_is_what_was_learnt(db: Path) -> None:
    shown = json.loads(run("tool", "show", "T1", "--db", db, "--json"))
    found, at = shown["learnt"], np.radians(shown["learnt"]["contact_angle_deg"])
    expected = learnt(history_of(opened(db), EDGE), at)
    assert expected is not None
    assert found["form_um"] == pytest.approx(1000 * expected.form.mean_mm, abs=1e-3)
    assert found["transfer_u_um"] == pytest.approx(1000 * expected.transfer.u_mm, abs=1e-3)
    assert found["setting_um"]["x_radius"] == pytest.approx(1000 * expected.setting_mm[0], abs=1e-3)
    assert list(found["by_type_um"]) == ["MODBAS2 B"]
    assert (shown["cuts"], shown["minutes_in_cut"], found["parts"], found["inspected"]) == (3, 9.0, 3, 3)
    behind = np.degrees(expected.behind.contact_angle_rad)
    beyond = (np.array(found["contact_angle_deg"]) > behind.max() + 6.0) | (
        np.array(found["contact_angle_deg"]) < behind.min() - 6.0
    )
    assert any(beyond) and not any(np.array(found["seen"])[beyond])


def test_the_table_has_dashes_where_nothing_was_seen(db: Path) -> None:
    table = [line.split() for line in output_of("tool", "show", "T1", "--db", db).splitlines() if "±" in line]
    assert any(line[0].lstrip("−-").isdigit() for line in table)
    dashes = [
        line for line in output_of("tool", "show", "T1", "--db", db).splitlines() if re.match(r"^ +-?\d+ +– ", line)
    ]
    assert dashes


def test_the_page_draws_curves_points_and_grey(db: Path, tmp_path: Path) -> None:
    page = tmp_path / "edge.html"
    output_of("tool", "show", "PCLNL", "--db", db, "-o", page)
    text = page.read_text(encoding="utf-8")
    assert all(f'<figure id="{name}"' in text for name in ("error", "form", "transfer", "types"))
    form = text[text.index('<figure id="form"') : text.index('<figure id="transfer"')]
    assert form.count("<circle") == len(history_of(opened(db), EDGE)[0].semifinish.point) * len(SERIALS)
    assert "part 2611 (MODBAS2 B)" in form
    assert 'fill="#e6eaee"' in form
    assert "http://" not in text.replace("http://www.w3.org", "")


def test_a_name_with_a_script_is_shown_not_run(tmp_path: Path) -> None:
    db, page = tmp_path / "trueloop.db", tmp_path / "edge.html"
    run("db", "init", db)
    bad = "<script>alert(1)</script>"
    run("tool", "mount", "T3", "--holder", bad, "--nose-radius-mm", 0.8, "--db", db)
    output_of("tool", "show", "T3", "--db", db, "-o", page)
    assert bad not in page.read_text(encoding="utf-8")


def test_cuts_after_a_turn_are_flagged(db: Path) -> None:
    run("tool", "turn", "T1", "--corner", "4", "--at", "2026-01-06T08:30:00+00:00", "--late", "--db", db)
    shown = json.loads(run("tool", "show", "T1", "--corner", "2", "--db", db, "--json"))
    assert [finding[:9] for finding in shown["findings"]] == ["EDG-ENDED", "EDG-ENDED"]
    assert shown["learnt"]["parts"] == 1  # the two teach nothing
    assert json.loads(run("tool", "show", "T1", "--db", db, "--json"))["learnt"] is None  # corner 4 knows nothing


def test_events_are_kept_as_stated(tmp_path: Path) -> None:
    db = tmp_path / "trueloop.db"
    run("db", "init", db)
    common = ("--db", db, "--machine", "lathe A")
    mounted = ("--holder", "H", "--insert", "I", "--corner", "1", "--nose-radius-mm", 0.4)
    run("tool", "mount", "T7", *mounted, "--at", "2026-03-02T08:00+01:00", *common)
    run("tool", "set", "t7", "--x-mm", -3.5, "--z-mm", 2, "--at", "2026-03-02T09:00+01:00", *common)
    run("tool", "wear", "7", "--flank-mm", 0.1, "--minutes-in-cut", 30, "--at", "2026-03-02T10:00+01:00", *common)
    run("tool", "remove", "H", "--at", "2026-03-02T11:00+01:00", *common)
    events = [kept.value for kept in find(opened(db), EdgeEvent)]
    assert [(str(event.kind), event.at.isoformat(), dict(event.values)) for event in events] == [
        ("mounted", "2026-03-02T07:00:00+00:00", {}),
        ("set", "2026-03-02T08:00:00+00:00", {"x_mm": -3.5, "z_mm": 2.0}),
        ("worn", "2026-03-02T09:00:00+00:00", {"flank_wear_mm": 0.1, "minutes_in_cut": 30.0}),
        ("removed", "2026-03-02T10:00:00+00:00", {}),
    ]
    assert {event.machine and event.machine.name for event in events} == {"lathe A"}
    assert events[0].edge.tool.corner_radius_mm == 0.4
    assert run("tool", "list", "--db", db) == "no edge is mounted\n"
    (known,) = json.loads(run("tool", "list", "--all", "--db", db, "--json"))["edges"]
    assert (known["ended_by"], known["nose_radius_mm"], known["machine"]) == ("removed", 0.4, "lathe A")


def test_minutes_in_cut_count_on_from_what_was_stated(db: Path) -> None:
    """Stated after two of three parts of 3 minutes: 20, and the third."""
    at = "2026-01-06T09:30:00+00:00"
    run("tool", "wear", "T1", "--minutes-in-cut", 20, "--at", at, "--late", "--db", db)
    assert json.loads(run("tool", "show", "T1", "--db", db, "--json"))["minutes_in_cut"] == 23.0


def test_a_refusal_leaves_the_store_as_it_was(db: Path) -> None:
    before = db.read_bytes()
    message = run("tool", "turn", "T1", "--corner", "2", "--db", db, status=3)
    assert message.startswith("EDG-CORNER") and db.read_bytes() == before
    assert invoke("tool", "set", "T1", "--at", "yesterday", "--db", db).exit_code == 2
    assert "EDG-PAST" in run("tool", "set", "T1", "--at", "2026-01-06T08:30+00:00", "--db", db, status=3)
    assert len(find(opened(db), Cut)) == 3


def test_without_a_store_it_says_how_to_make_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "trueloop db init" in run("tool", "list", status=3)
