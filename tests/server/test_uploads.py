"""A whole part over HTTP: files handed over, looked at, kept; made, measured, certified and released."""

from base64 import b64decode, b64encode
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from ezdxf.filemanagement import new

from tests.support.service import Caller, Running, problem
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.factory.tasks import run_task
from trueloop.jobs.factory.runners import RUNNERS
from trueloop.jobs.factory.uploads import KEPT, HandedFile, kind_of
from trueloop.storage.store import find

MODBAS2 = Path(__file__).parents[2] / "src" / "trueloop" / "examples" / "modbas2"
TOUCHES = (MODBAS2 / "touches.csv").read_bytes()
SERIAL = "2511.161"
PROBE = b"(probe)\nG21 G1 X1 F1\nM2\n"


SIZES = b"""Serial;Characteristic;Feature;Nominal;Lower limit;Upper limit;Actual;Unit
2511.161;Diameter 1;main-cylinder;89.408;89.390;89.430;89.4102;mm
2511.161;Diameter 2;small-cylinder;74.168;74.150;74.190;74.1665;mm
"""


def hand_over(caller: Caller, name: str, content: bytes) -> dict[str, Any]:
    answer = caller.ask("POST", "uploads", params={"name": name}, content=content)
    assert answer.status_code == 201, answer.text
    return dict(answer.json())


def programs(ana: Caller) -> dict[str, str]:
    """The programs of the example, handed over, kept and released: their hashes."""
    texts = {name: (MODBAS2 / f"{name}.nc").read_bytes() for name in ("semifinish", "finish")}
    found = {}
    for name, text, dialect in (*((k, v, "ge2000t") for k, v in texts.items()), ("probe", PROBE, "linuxcnc")):
        seen = hand_over(ana, f"{name}.nc", text)
        assert (seen["kind"], seen["sha256"]) == ("program", sha256(text).hexdigest())
        kept = ana.post(f"uploads/{seen['sha256']}/program", {"dialect": dialect})
        assert kept.status_code == 201, kept.text
        assert ana.post(f"programs/{kept.json()['sha256']}/release", {"why": "ran in"}).status_code == 200
        found[name] = kept.json()["sha256"]
    return found


def planned(ana: Caller, sha: dict[str, str]) -> dict[str, Any]:
    kinds = ("semifinish", "probe", "correct", "finish", "remove", "measure", "release")
    blocks = [{"kind": kind, "program_sha256": sha.get(kind, ""), "corrected": kind == "finish"} for kind in kinds]
    order = {
        "part_type": "MODBAS2, 3.52 in",
        "revision": "",
        "machine": "lathe",
        "new_machine": True,
        "serials": [SERIAL],
        "blocks": blocks,
        "job_toml": (MODBAS2 / "job.toml").read_text(encoding="utf-8"),
        "conditions": {"temperature_age_s": None, "calibration_age_s": None},
    }
    answer = ana.post("orders", order)
    assert answer.status_code == 201, answer.text
    return dict(answer.json())


def cut(service: Running, cell: Caller) -> str:
    """The next block, run: its key."""
    offer = cell.post("cell/next").json()
    key, sent = offer["run"]["key"], sha256(b64decode(offer["program"])).hexdigest()
    at = service.clock().isoformat()
    facts = [
        {"run": key, "what": what, "at": at, "witness": "program", "values": {"read_back_sha256": sent}}
        for what in ("sent", "verified", "started", "ended")
    ]
    answer = cell.post("cell/facts", {"facts": facts})
    assert answer.status_code == 200, answer.text
    return str(key)


def finished(service: Running) -> tuple[Caller, dict[str, Any]]:
    """An order whose one part is out of the machine."""
    ana, cell = service.signed_in("engineer"), service.cell()
    order = planned(ana, programs(ana))
    cut(service, cell)
    service.clock.turn(minutes=5)
    touches = {"run": cut(service, cell), "name": "touches.csv", "file": b64encode(TOUCHES).decode()}
    assert cell.post("cell/touches", touches).status_code == 200
    task = run_task(service.store, RUNNERS, "worker", service.clock)
    assert task is not None and task.state == "done", task
    service.clock.turn(minutes=5)
    cut(service, cell)
    service.clock.turn(minutes=5)
    part = order["parts"][0]["id"]
    now = ana.get(f"orders/{order['row']['id']}")
    removed = ana.post(
        f"orders/{order['row']['id']}/parts/{part}/record",
        {"step": 4, "why": "out"},
        headers={"If-Match": now.headers["etag"]},
    )
    assert removed.status_code == 200, removed.text
    return ana, dict(removed.json())


def after_finish(factor: float) -> bytes:
    """Errors after the finish cut: a part of those before it."""
    lines = [line for line in TOUCHES.decode().splitlines() if not line.startswith("#")]
    rows = [f"{row.rpartition(',')[0]},{factor * float(row.rpartition(',')[2]):.3f}" for row in lines[1:]]
    return "\n".join([lines[0], *rows, ""]).encode()


def test_a_part_is_made_measured_certified_and_released_over_http(service: Running) -> None:
    ana, order = finished(service)
    number, part = order["row"]["id"], order["parts"][0]["id"]
    seen = hand_over(ana, "after.csv", after_finish(0.05))
    shown = ana.post(f"uploads/{seen['sha256']}/read", {"order": number}).json()
    (inspection,) = shown["measurement"]["inspections"]
    assert inspection["count"] == len(TOUCHES.splitlines()) - 2
    assert {one["feature"] for one in inspection["values"]} >= {"cone", "main-cylinder", "dome"}
    assert len(find(service.store, InspectionLink)) == 1  # of the touches: nothing is kept by looking
    kept = ana.post(f"uploads/{seen['sha256']}/measurement", {"order": number, "part": part})
    assert kept.status_code == 201, kept.text
    assert kept.json()["recorded"] is True and kept.json()["new"] > 0
    (made,) = (one.value for one in find(service.store, Cut, stage=Stage.FINISH))
    assert made.correction and made.part.serial == SERIAL
    (correction,) = ana.get(f"parts/{part}/life").json()["corrections"]
    assert correction["has_report"] and correction["id"] == made.correction
    report = ana.get(f"corrections/{made.correction}/report", params={"language": "de"})
    assert "sandbox" in report.headers["content-security-policy"]
    assert '<html lang="de"' in report.text and "<svg" in report.text and "Korrektur" in report.text
    assert problem(ana.get("corrections/none/report")) == "FAC-UNKNOWN"
    assert problem(ana.post("certificates", {"part": part})) == "MON-NONE"  # errors are no sizes
    sizes = hand_over(ana, "sizes.csv", SIZES)
    of = {"order": number, "part": part, "mapping_toml": sizes["measurement"]["mapping_toml"]}
    kept = ana.post(f"uploads/{sizes['sha256']}/measurement", of)
    assert kept.status_code == 201 and not kept.json()["recorded"], kept.text
    certified = ana.post("certificates", {"part": part})
    assert certified.status_code == 201, certified.text
    page = ana.get(f"certificates/{certified.json()['id']}")
    assert SERIAL in page.text and certified.json()["serial"] == SERIAL
    now = ana.get(f"orders/{number}")
    assert now.json()["parts"][0]["state"] == "measured"
    done = ana.post(
        f"orders/{number}/parts/{part}/record", {"step": 6, "why": "good"}, headers={"If-Match": now.headers["etag"]}
    )
    assert done.json()["parts"][0]["state"] == "released", done.text


def test_the_same_measurement_twice_is_kept_once(service: Running) -> None:
    ana, order = finished(service)
    seen = hand_over(ana, "after.csv", after_finish(0.05))
    of = {"order": order["row"]["id"], "part": order["parts"][0]["id"]}
    first, second = (ana.post(f"uploads/{seen['sha256']}/measurement", of).json() for _ in range(2))
    assert (first["recorded"], second["recorded"], second["new"]) == (True, False, 0)


def test_a_measurement_that_cannot_be_of_the_part_is_refused_and_nothing_kept(service: Running) -> None:
    ana, order = finished(service)
    seen = hand_over(ana, "after.csv", after_finish(20.0))
    of = {"order": order["row"]["id"], "part": order["parts"][0]["id"]}
    assert problem(ana.post(f"uploads/{seen['sha256']}/measurement", of)) == "TCH-OFF-PROFILE"
    assert not find(service.store, Cut, stage=Stage.FINISH)
    assert ana.get(f"orders/{of['order']}").json()["parts"][0]["state"] == "removed"


def test_a_table_shows_what_its_columns_mean_and_is_read_by_what_is_said(service: Running) -> None:
    otto = service.signed_in("operator")
    seen = hand_over(otto, "shift 3.csv", SIZES)
    mapping = seen["measurement"]["mapping_toml"]
    assert 'actual = "Actual"' in mapping
    first = seen["measurement"]["inspections"][0]["values"][0]
    assert (first["lower_limit"], first["upper_limit"], first["within"]) == (89.39, 89.43, True)
    wrong = mapping.replace('actual = "Actual"', 'actual = "Nominal"').replace('nominal = "Nominal"\n', "")
    again = otto.post(f"uploads/{seen['sha256']}/read", {"mapping_toml": wrong}).json()
    (inspection,) = again["measurement"]["inspections"]
    assert inspection["values"][0]["actual"] == 89.408
    broken = otto.post(f"uploads/{seen['sha256']}/read", {"mapping_toml": "columns = 3"}).json()
    assert broken["problem"]["code"].startswith("MSR-") and "/tmp" not in str(broken)


def test_a_file_of_another_part_is_refused(service: Running) -> None:
    ana, order = finished(service)
    seen = hand_over(ana, "sizes.csv", SIZES.replace(b"2511.161", b"2511.162"))
    of = {"order": order["row"]["id"], "part": order["parts"][0]["id"]}
    of["mapping_toml"] = seen["measurement"]["mapping_toml"]
    assert problem(ana.post(f"uploads/{seen['sha256']}/measurement", of)) == "MSR-SERIAL"
    assert not find(service.store, Cut, stage=Stage.FINISH)


@pytest.mark.parametrize("name", ["../../etc/cron.d/x.nc", "<script>alert(1)</script>", ".." * 50])
def test_no_name_is_a_path(service: Running, name: str) -> None:
    otto = service.signed_in("operator")
    seen = hand_over(otto, name, b"G21 G90\nG1 X1 F1\nM2\n")
    assert seen["name"] == name and seen["kind"] == "program"


@pytest.mark.parametrize("name", ["", "a\x00b", "a\nb", "x" * 201])
def test_what_is_no_name_is_refused(service: Running, name: str) -> None:
    otto = service.signed_in("operator")
    assert problem(otto.ask("POST", "uploads", params={"name": name}, content=b"M2")) == "SRV-REQUEST"


def test_a_drawing_is_shown_as_the_table_of_a_job(service: Running, tmp_path: Path) -> None:
    drawing = new(units=4)
    for start, end in (((10, -30), (10, -5)), ((10, -5), (5, 0)), ((5, 0), (0, 0))):
        drawing.modelspace().add_line((start[1], start[0]), (end[1], end[0]))
    drawing.saveas(tmp_path / "shaft.dxf")
    seen = hand_over(service.signed_in("operator"), "shaft.dxf", (tmp_path / "shaft.dxf").read_bytes())
    assert seen["problem"] is None and seen["drawing"]["part_toml"].count("name =") == 4, seen


def test_what_is_handed_over_is_its_owners_and_for_a_day(service: Running) -> None:
    otto, ana = service.signed_in("operator"), service.signed_in("engineer")
    seen = hand_over(otto, "a.nc", b"G21 G1 X1 F1\nM2\n")
    assert problem(ana.post(f"uploads/{seen['sha256']}/read", {})) == "FAC-UNKNOWN"
    service.clock.turn(seconds=KEPT.total_seconds() + 3600)
    hand_over(service.signed_in("operator"), "b.nc", b"M2\n")
    assert problem(service.signed_in("operator").post(f"uploads/{seen['sha256']}/read", {})) == "FAC-UNKNOWN"


@pytest.mark.parametrize("ending", ["csv", "tsv", "xlsx", "xlsm", "xlsb", "xls", "ods"])
def test_tables_are_known_by_their_ending(ending: str, tmp_path: Path) -> None:
    file = tmp_path / f"values.{ending.upper()}"
    file.write_bytes(b"PK\x03\x04")
    assert kind_of(HandedFile(str(file), file.name, "")) == "measurement"


@pytest.mark.parametrize(("content", "kind"), [(SIZES, "measurement"), (PROBE, "program")])
def test_a_text_is_a_table_by_its_headings(content: bytes, kind: str, tmp_path: Path) -> None:
    file = tmp_path / "handed.txt"
    file.write_bytes(content)
    assert kind_of(HandedFile(str(file), file.name, "")) == kind


def test_what_is_no_program_says_so(service: Running) -> None:
    seen = hand_over(service.signed_in("operator"), "noise.bin", bytes(range(256)) * 40)
    assert seen["problem"]["code"].startswith("NC-") and seen["problem"]["hint"]
