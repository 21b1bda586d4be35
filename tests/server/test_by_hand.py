"""A part corrected by a person over HTTP: shown, measured, corrected; refused as the command line refuses."""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta, timezone
from io import StringIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from ezdxf.filemanagement import new as new_drawing
from httpx2 import Response
from sqlalchemy import select

from tests.server.test_apart import FOREVER
from tests.server.test_uploads import hand_over
from tests.support.new_stores import new_file
from tests.support.service import Caller, Running, problem, started
from trueloop.domain.inspection import Inspection
from trueloop.domain.record import sha256_of
from trueloop.jobs.factory.by_hand import made_before
from trueloop.jobs.factory.hand_job import AskedPart
from trueloop.jobs.milled import entries_for_next_part, entry_lines, read_milled
from trueloop.jobs.monitor.certificate import certify_part
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.turned.compensate import compensate_job, compensate_part
from trueloop.jobs.turned.new import Wanted, gauge_sheet_of, new_job
from trueloop.server.settings import Limits, Settings
from trueloop.storage.schema import UPLOAD
from trueloop.storage.store import find, open_store

EXAMPLES = Path(__file__).parents[2] / "src" / "trueloop" / "examples"
SHAFT = (EXAMPLES / "shaft" / "finish.nc").read_bytes()
READ = {
    "cylinder-1 a": "44.031",
    "cylinder-1 b": "44.027",
    "cylinder-2 a": "36.025",
    "cylinder-2 b": "36.022",
    "cylinder-3 a": "30.016",
    "cylinder-4 a": "24.013",
}
AFTER = {
    "cylinder-1 a": "44.006",
    "cylinder-1 b": "44.006",
    "cylinder-2 a": "36.005",
    "cylinder-2 b": "36.006",
    "cylinder-3 a": "30.005",
    "cylinder-4 a": "24.006",
}


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Running]:
    store = open_store(new_file(tmp_path / "service.db"), codec=store_codec())
    yield started(store)
    store.close()


def part_of(caller: Caller, program: bytes = SHAFT, file: str = "finish.nc", **stated: Any) -> dict[str, Any]:
    sha = hand_over(caller, file, program)["sha256"]
    return {"program": sha, "nose_radius_mm": 0.8, "dialect": "fanuc-lathe", "name": "shaft", **stated}


def measured(values: Mapping[str, str] = READ, **stated: Any) -> dict[str, Any]:
    return {
        "values": {name: [value] for name, value in values.items()},
        "serial": "0017",
        "expanded_uncertainty_um": 4.0,
        **stated,
    }


def test_a_german_reader_is_refused_in_german(service: Running) -> None:
    """Also what a process apart refuses; by `Accept-Language`, as the pages send it, or by the address."""
    german = replace(service.signed_in("operator"), headers={"Accept-Language": "de"})
    said = correction(german, part_of(german), measured({**READ, "cylinder-3 a": "1.1817"}))
    assert problem(said) == "MSR-NOMINAL"
    assert said.json()["detail"].startswith("'cylinder-3 a' ist 1,1817 mm, Nennmaß 30: Kein Fehler eines Schnitts")
    assert said.json()["hint"].startswith("Die Messwerte eines anderen Teils")
    asked, otto = {**part_of(german), "dialect": None}, service.signed_in("operator")
    untold = "das Programm sagt nicht, für welche Steuerung es ist"
    for caller, query, text in ((german, {}, untold), (otto, {"language": "de"}, untold), (otto, {}, "does not tell")):
        assert text in caller.post("by-hand/part", asked, params=query).json()["problem"]["said"]
    assert "passen nicht zusammen" in german.post("session", {"name": "otto", "password": "no"}).json()["detail"]
    assert german.get("parts/99/life").json()["detail"].startswith("Teil '99' gibt es nicht")


def corrected(caller: Caller, part: dict[str, Any], readings: dict[str, Any], **query: str) -> dict[str, Any]:
    answer = caller.post("by-hand/correction", {"part": part, "measured": readings}, params=query)
    assert answer.status_code == 201, answer.text
    return dict(answer.json())


def file_of(caller: Caller, made: dict[str, Any], name: str) -> bytes:
    (sha,) = [one["sha256"] for one in made["files"] if one["name"] == name]
    return bytes(caller.get(f"uploads/{sha}/file").content)


def by_command(folder: Path, values: Mapping[str, str], *more: str, serial: str = "0017") -> bytes:
    """The corrected program of `trueloop new` and `trueloop compensate` in a folder whose store they share."""
    if not (folder / "trueloop.db").exists():
        new_file(folder / "trueloop.db")
    made = new_job(Wanted(folder / "finish.nc", 0.8, "shaft", folder / serial, dialect="fanuc-lathe"))
    sheet = folder / serial / "readings.csv"
    rows = sheet.read_text().replace("# expanded_uncertainty_um:", "# expanded_uncertainty_um: 4.0").splitlines()
    sheet.write_text("\n".join(row + values.get(row.partition(",")[0], "") for row in rows) + "\n")
    job = made.files[0]
    text = job.read_text().replace("[part]", f'[part]\nserial = "{serial}"', 1)
    job.write_text(text.replace("[programs]", "\n".join(["[programs]", *more]), 1))
    compensate_job(job, store=str(folder / "trueloop.db"))
    return (folder / serial / "out" / "corrected.nc").read_bytes()


def chuck_end_mm(program: bytes) -> float:
    """The last diameter that is cut, at z −112."""
    (line,) = [one for one in program.decode().splitlines() if "Z-112" in one]
    return float(re.findall(r"X([\d.]+)", line)[0])


def moves(program: bytes) -> list[str]:
    """Its lines but for the ids of records."""
    return [line for line in program.decode().splitlines() if not re.search("trueloop|: record ", line)]


def test_a_program_is_shown_as_a_part_with_the_sizes_to_measure(service: Running) -> None:
    otto = service.signed_in("operator")
    seen = otto.post("by-hand/part", part_of(otto)).json()
    assert seen["problem"] is None and seen["question"] is None, seen
    assert (seen["dialect"], seen["unit"], seen["tools"]) == ("fanuc-lathe", "mm", ["T3"])
    assert seen["features"][0] == "cylinder-1" and len(seen["features"]) == 11
    assert [(one["number"], one["name"], one["nominal"]) for one in seen["sizes"][:3]] == [
        (1, "cylinder-1 a", 44.0),
        (2, "cylinder-1 b", 44.0),
        (3, "face-1 length", 80.0),
    ]
    for drawn in (seen["picture"]["wide"], seen["picture"]["narrow"]):
        assert drawn.startswith("<svg") and "cylinder-1" in drawn and ">9</text>" in drawn
    assert problem(service.signed_in("viewer").post("by-hand/part", part_of(otto))) == "SRV-ROLE"
    ana = service.signed_in("engineer")  # who has not handed it over
    assert problem(ana.post("by-hand/part", part_of(otto))) == "FAC-UNKNOWN"


def test_readings_have_the_time_at_which_they_were_taken(service: Running) -> None:
    otto = service.signed_in("operator")
    part, now = part_of(otto), datetime.now(UTC).astimezone(timezone(timedelta(hours=5)))
    assert corrected(otto, part, measured(measured_at=(now - timedelta(hours=1)).isoformat()))["files"]
    old = measured(measured_at=(now - timedelta(days=9)).isoformat(), serial="0009")
    assert problem(otto.post("by-hand/correction", {"part": part, "measured": old})) == "CMP-AGE"
    naive = measured(measured_at="2026-11-20T09:40:00")
    assert problem(otto.post("by-hand/correction", {"part": part, "measured": naive})) == "SRV-REQUEST"


def test_two_parts_are_corrected_as_by_the_command_line(service: Running, tmp_path: Path) -> None:
    """The second correction is the whole one: what was in force, and what the second part adds."""
    (tmp_path / "finish.nc").write_bytes(SHAFT)
    otto = service.signed_in("operator")
    part = part_of(otto)
    first = corrected(otto, part, measured())
    assert first["kept"] is True
    assert not any("folders near" in note for note in first["notes"])  # of other people's corrections
    contour, wear = first["ways"]
    assert (contour["by"], contour["program"], contour["enter"]) == ("corrected", "corrected.nc", "")
    assert wear["by"] == "wear" and wear["given"] and wear["program"] == "finish.nc"
    assert wear["enter"].startswith("T3 wear X −0.022 mm (diameter), Z +0.000 (X ± 0.012")
    assert moves(file_of(otto, first, "corrected.nc")) == moves(by_command(tmp_path, READ))
    assert b"<svg" in file_of(otto, first, "report.html")
    assert json.loads(file_of(otto, first, "record.json"))["made_by"] == "operator"  # the account that is signed in
    (known,) = otto.post("by-hand/part", part).json()["made_before"]
    assert (known["id"], known["serial"], known["ways"]) == (first["id"], "0017", ["corrected", "wear"])
    assert known["tool"] == "T3"
    for stale in ({"cut_with": "given"}, {"cut_with": "given", "made_before": ["0" * 16]}):  # shown before the first
        refused = otto.post("by-hand/correction", {"part": part, "measured": measured(AFTER, serial="0018", **stale)})
        assert problem(refused) == "CMP-CUT-WITH" and first["id"] in refused.json()["detail"]
    assert len(find(service.store, Inspection)) == 1

    for serial in ("0018", ""):  # one without a number is not kept, and what cut it is asked for all the same
        unsaid = otto.post("by-hand/correction", {"part": part, "measured": measured(AFTER, serial=serial)})
        assert problem(unsaid) == "CMP-CUT-WITH"
        assert first["id"] in unsaid.json()["detail"]
    said = {"cut_with": first["id"], "cut_by": "corrected", "made_before": [first["id"]]}
    second = corrected(otto, part, measured(AFTER, serial="0018", **said))
    ends = [chuck_end_mm(file_of(otto, one, "corrected.nc")) for one in (first, second)]
    assert ends[0] == pytest.approx(44.0 - 0.031, abs=0.002)
    assert ends[1] - ends[0] == pytest.approx(-0.006, abs=0.002)  # diameters, as the second part was read
    record = by_command(tmp_path, AFTER, f'cut_with = "{first_id(tmp_path)}"', 'cut_by = "corrected"', serial="0018")
    assert moves(file_of(otto, second, "corrected.nc")) == moves(record)
    said["made_before"] = [one["id"] for one in otto.post("by-hand/part", part).json()["made_before"]]
    assert said["made_before"] == [second["id"], first["id"]]
    alone = corrected(otto, part, measured(AFTER, serial="", **said))
    assert alone["kept"] is False and moves(file_of(otto, alone, "corrected.nc")) == moves(record)


def first_id(folder: Path) -> str:
    """The only correction in the store of the command line."""
    store = open_store(folder / "trueloop.db", codec=store_codec())
    try:
        return made_before(store, AskedPart(sha256_of(SHAFT), 0.8))[0].id
    finally:
        store.close()


def in_inches(program: bytes) -> bytes:
    """The words X, Z and R of a program as inches, to the millionth, with G20."""
    text = re.sub(r"(?<=[XZR])-?\d+\.\d+", lambda one: f"{float(one[0]) / 25.4:.6f}", program.decode())
    return text.replace("G21", "G20").replace("F0.12", "F0.005").encode()


def test_an_inch_program_is_measured_in_inches(service: Running) -> None:
    otto = service.signed_in("operator")
    part = part_of(otto, in_inches(SHAFT))
    seen = otto.post("by-hand/part", part).json()
    assert seen["unit"] == "inch" and seen["sizes"][0]["nominal"] == pytest.approx(44.0, abs=1e-4)
    inches = {name: f"{float(value) / 25.4:.5f}" for name, value in READ.items()}
    made = corrected(otto, part, measured(inches, by="offset"))
    (wear,) = [one for one in made["ways"] if one["by"] == "wear"]
    found = re.match(r"T3 wear X −(0\.\d+) inch \(diameter\)", wear["enter"])
    assert found and float(found[1]) * 25.4 == pytest.approx(0.022, abs=0.002), wear
    assert problem(correction(otto, part, measured(READ))) == "MSR-SCALE"  # mm for inches


SIEMENS = b"""; SHAFT
N10 G90 G18 G71 G95 DIAMON
N20 T="FINISH" D1
N30 G96 S220 M4
N40 G0 X30 Z5
N50 G42 G0 X-1.6 Z2
N60 G1 Z0 F0.12
N70 X22
N80 X24 Z-1
N90 Z-10.5
N100 G2 X27 Z-12 CR=1.5
N110 G1 X30
N120 Z-30
N130 X36 Z-45
N140 Z-78
N150 G2 X40 Z-80 CR=2
N160 G1 X44
N170 Z-112
N180 X50
N190 G40 G0 X80 Z50
N200 M30
"""


def test_a_siemens_program_is_corrected_by_its_contour(service: Running) -> None:
    otto = service.signed_in("operator")
    part = part_of(otto, SIEMENS, dialect=None)
    seen = otto.post("by-hand/part", part).json()
    assert seen["dialect"] == "siemens" and len(seen["features"]) == 11, seen
    made = corrected(otto, part, measured(by="contour"), language="de")
    (way,) = made["ways"]
    assert (way["by"], way["enter"]) == ("corrected", "")
    program = file_of(otto, made, way["program"]).decode()
    ends = re.findall(r"X=?(43\.\d+)", program)  # 44 less a wear of 0.022 and the taper
    assert ends and all(43.965 < float(one) < 43.985 for one in ends), program
    assert "Erwart" in made["headline"] or "erwart" in made["headline"], made["headline"]


def test_what_a_program_does_not_say_is_asked_for(service: Running) -> None:
    otto = service.signed_in("operator")
    unsaid = otto.post("by-hand/part", part_of(otto, b"G00 X30. Z5.\nG01 X20. Z0. F0.1\nZ-20.\nM30\n", dialect=None))
    assert unsaid.json()["problem"]["code"] == "NC-DIALECT"
    assert unsaid.json()["question"]["about"] == "dialect" and "haas-lathe" in unsaid.json()["question"]["choices"]
    unitless = SHAFT.replace(b"G21 ", b"")
    seen = otto.post("by-hand/part", part_of(otto, unitless)).json()
    assert seen["problem"]["code"] == "NC-UNIT" and seen["question"] == {
        "about": "unit",
        "choices": ["mm", "inch"],
        "program": 0,
    }
    assert otto.post("by-hand/part", part_of(otto, unitless, unit="mm")).json()["problem"] is None
    family = (EXAMPLES / "modbas2" / "finish.nc").read_bytes()
    part = part_of(otto, family, dialect="ge2000t", nose_radius_mm=0.79375)
    seen = otto.post("by-hand/part", part).json()
    assert seen["question"] == {"about": "parameters", "choices": ["P42", "P46", "P47"], "program": 0}, seen
    part["parameters"] = {"P42": 8.0, "P46": 3.52, "P47": 0.0}
    seen = otto.post("by-hand/part", part).json()
    assert seen["problem"] is None and seen["unit"] == "inch" and len(seen["features"]) == 7, seen


def correction(caller: Caller, part: dict[str, Any], readings: dict[str, Any]) -> Response:
    return caller.post("by-hand/correction", {"part": part, "measured": readings})


def test_what_cannot_be_right_is_refused_and_nothing_kept(service: Running) -> None:
    otto = service.signed_in("operator")
    part = part_of(otto)
    inch = {**READ, "cylinder-3 a": "1.1817"}
    assert problem(correction(otto, part, measured(inch))) == "MSR-NOMINAL"
    assert problem(correction(otto, part, measured({**READ, "cylinder-3 a": "30.O16"}))) == "MSR-NUMBER"
    assert problem(correction(otto, part, measured({}))) == "MSR-NONE"
    assert problem(correction(otto, part, measured({**READ, "cylinder-9 a": "1"}))) == "MSR-FEATURE"
    large = {name: f"{float(value) + 1.0:.3f}" for name, value in READ.items()}
    assert problem(correction(otto, part, measured(large))) == "CMP-SIZE"
    drilled = part_of(otto, b"%\nO1\nG21 G18 G40 G99\nT0101\nG00 X0. Z5.\nG01 Z-20. F0.1\nG00 Z5.\nM30\n%\n")
    seen = otto.post("by-hand/part", drilled).json()
    assert seen["problem"]["code"].startswith(("NC-", "GEO-")) and seen["problem"]["hint"] and not seen["features"]
    assert problem(correction(otto, drilled, measured())) == seen["problem"]["code"]
    assert not find(service.store, Inspection)


def test_no_file_of_the_server_is_read_and_no_folder_named(
    service: Running, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    otto = service.signed_in("operator")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "O2000").write_text("G01 X1. Z1.\nM99\n")
    calling = SHAFT.replace(b"M30\n", f"M98 P2000\nM98 ({tmp_path}/O2000)\nM30\n".encode())
    seen = otto.post("by-hand/part", part_of(otto, calling)).json()
    assert seen["problem"]["code"] == "NC-FLOW", seen
    assert "/tmp" not in seen["problem"]["said"].replace(str(tmp_path), ""), seen
    part = part_of(otto)
    for key, value in (("cut_with", "../../record.json"), ("cut_with", "/etc/passwd"), ("serial", 'a"\nx = 1')):
        assert problem(correction(otto, part, {**measured(), key: value})) == "SRV-REQUEST"
    for key in ("program", "drawing"):
        assert problem(otto.post("by-hand/part", {**part, key: "/etc/passwd"})) == "SRV-REQUEST"
    named = corrected(otto, part_of(otto, name='"]\\n[programs]'), measured(instrument='"""\'[part]'))
    assert 'name = "\\"]' in file_of(otto, named, "job.toml").decode()


def test_a_file_of_measurements_takes_the_place_of_values(service: Running) -> None:
    otto = service.signed_in("operator")
    part = part_of(otto)
    at_z = (-105.6, -86.4, -71.4, -51.6, -26.4, -5.75)
    rows = [f"{name[:-2]},{z},{READ[name]}" for name, z in zip(READ, at_z, strict=True)]
    text = "\n".join(["# expanded_uncertainty_um: 4", "feature,z_mm,diameter_mm", *rows, ""]).encode()
    file = hand_over(otto, "shift 3.csv", text)["sha256"]
    typed = corrected(otto, part, measured(by="contour", serial="1"))
    unkept = {"cut_with": "given", "made_before": [typed["id"]]}
    read = corrected(otto, part, {"file": file, "by": "contour", **unkept})
    assert moves(file_of(otto, typed, "corrected.nc")) == moves(file_of(otto, read, "corrected.nc"))

    bare = hand_over(otto, "bare.csv", text.partition(b"\n")[2])["sha256"]
    own = hand_over(otto, "own.csv", text.replace(b": 4", b": 8"))["sha256"]
    typed_u_um, own_u_um = (
        corrected(otto, part, {"by": "contour", **given, **unkept})["features"][0]["expanded_u_um"]
        for given in ({"file": bare, "expanded_uncertainty_um": 8.0}, {"file": own})
    )
    assert typed_u_um == pytest.approx(own_u_um) and own_u_um > read["features"][0]["expanded_u_um"] + 0.3
    assert problem(correction(otto, part, {**measured(), "file": bare, **unkept})) == "SRV-REQUEST"


def test_the_corrections_of_another_tool_are_not_offered(service: Running) -> None:
    """A program that calls no tool is cut by the tool that is stated."""
    otto = service.signed_in("operator")
    uncalled = SHAFT.replace(b"T0303", b"")
    assert uncalled != SHAFT
    third, fifth = (part_of(otto, uncalled, tool=number) for number in (3, 5))
    made = corrected(otto, third, measured())
    (known,) = otto.post("by-hand/part", third).json()["made_before"]
    assert (known["id"], known["tool"]) == (made["id"], "T3")
    assert otto.post("by-hand/part", fifth).json()["made_before"] == []
    corrected(otto, fifth, measured(serial="0018", cut_with="given"))  # all that there are were shown


def test_a_part_keeps_its_name_and_files_keep_theirs(service: Running) -> None:
    otto = service.signed_in("operator")
    part = part_of(otto, file="Shaft A.nc", name="")
    known: list[str] = []
    for serial in ("1", "2", "3"):
        made = corrected(otto, part, measured(serial=serial, cut_with="given", made_before=known))
        known.append(made["id"])
        assert otto.post("by-hand/part", part).json()["name"] == "Shaft A"
    with service.store.reading() as connection:
        names = connection.execute(select(UPLOAD.c.name).where(UPLOAD.c.sha256 == part["program"])).scalars().all()
    assert names == ["Shaft A.nc"]
    again = part_of(otto, file="O0815.nc", name="")
    corrected(otto, again, measured(serial="4", cut_with="given", made_before=known))
    assert {one.value.part.part_type.name for one in find(service.store, Inspection)} == {"Shaft A"}


@pytest.mark.parametrize("file", ["job.toml", "readings.csv", "sheet.html", "out"])
def test_a_program_may_have_the_name_of_a_file_of_the_job(service: Running, file: str) -> None:
    otto = service.signed_in("operator")
    made = corrected(otto, part_of(otto, file=file), measured())
    assert made["ways"][0]["by"] == "corrected"
    ends = chuck_end_mm(file_of(otto, made, made["ways"][0]["program"]))
    assert ends == pytest.approx(44.0 - 0.031, abs=0.002)


def test_a_program_that_takes_too_long_is_refused(tmp_path: Path) -> None:
    store = open_store(new_file(tmp_path / "limited.db"), codec=store_codec())
    otto = started(store, Settings(poll_s=0.01, workers=0, limits=Limits(read_s=2.0))).signed_in("operator")
    assert problem(otto.ask("POST", "uploads", params={"name": "forever.ngc"}, content=FOREVER)) == "SRV-FILE"
    part = {"program": sha256_of(FOREVER), "nose_radius_mm": 0.8, "dialect": "linuxcnc"}
    assert problem(otto.post("by-hand/part", part)) == "SRV-FILE"
    assert problem(correction(otto, part, measured())) == "SRV-FILE"
    store.close()


def test_tolerances_as_the_drawing_has_them_make_a_certificate(service: Running) -> None:
    """A first part out of its limits, the next one inside; the sheet of the second has the tolerances of the first."""
    otto = service.signed_in("operator")
    part, stated = part_of(otto), {"cylinder-1": "±0.02", "cylinder-2": "h6", "face-1 length": "+0.1/0"}
    stated |= {"cylinder-3": "ISO 2768-f", "cylinder-4": "+0,03 0"}
    seen = otto.post("by-hand/part", part).json()
    assert [one["tolerance_name"] for one in seen["sizes"][:4]] == 2 * ["cylinder-1"] + ["face-1 length", "cylinder-2"]
    assert seen["tolerances"] == {}
    out = corrected(otto, part, measured(tolerances=stated, instrument="micrometer"))
    seen = otto.post("by-hand/part", part).json()
    assert seen["tolerances"] == stated
    unread = measured(tolerances={"cylinder-1": "about 1"})
    assert problem(otto.post("by-hand/correction", {"part": part, "measured": unread})) == "TOL-TEXT"
    other = measured(tolerances={"cylinder-1 a": "h6"})
    assert problem(otto.post("by-hand/correction", {"part": part, "measured": other})) == "MSR-FEATURE"
    assert certify_part(service.store, "0017", "shaft").outcome == "does not conform"
    inside = AFTER | {"cylinder-2 a": "35.992", "cylinder-2 b": "35.993", "face-1 length": "80.05"}
    stated_cut = {
        "cut_with": out["id"],
        "cut_by": "corrected",
        "made_before": [one["id"] for one in seen["made_before"]],
    }
    corrected(otto, part, measured(inside, serial="0018", instrument="micrometer", tolerances=stated, **stated_cut))
    of_next = certify_part(service.store, "0018", "shaft")
    assert of_next.outcome == "conforms"
    limits = {one.characteristic: (one.lower_limit, one.upper_limit) for one in of_next.characteristics}
    # ISO 286: IT6 of 30 to 50 mm is 16 µm
    assert limits["cylinder-2"] == pytest.approx((35.984, 36.0)) and limits["face-1 length"] == pytest.approx(
        (80.0, 80.1)
    )


def test_a_tolerance_is_in_the_unit_of_the_program(tmp_path: Path) -> None:
    """±0.001 in of 1.5 in on the diameter is 38.1 ± 0.0254 mm; h6 of 25.4 mm is 13 µm in any unit [ISO 286]."""
    program = "G20 G40 G99\nT0101\nG0 X0.9 Z0.1\nG42 G1 X1. F0.004\nZ-1.\nX1.5\nZ-2.\nG40 G0 X2. Z0.2\nM30\n"
    (tmp_path / "finish.nc").write_text(f"%\nO1\n{program}%\n")
    stated = {"cylinder-1": "±0.001", "cylinder-2": "h6"}
    made = new_job(
        Wanted(tmp_path / "finish.nc", 0.4, "pin", tmp_path / "pin", dialect="fanuc-lathe", tolerances=stated)
    )
    sizes = gauge_sheet_of(made.files[0]).planned
    limits = {one.feature: (one.nominal, one.lower_limit, one.upper_limit) for one in sizes if one.name.endswith(" a")}
    assert limits["cylinder-1"] == pytest.approx((38.1, 38.0746, 38.1254))
    assert limits["cylinder-2"] == pytest.approx((25.4, 25.387, 25.4))


TWO_SIDES = EXAMPLES / "two-sides"
SIDES = [(TWO_SIDES / name).read_bytes() for name in ("first.nc", "second.nc")]
OF_SIDES = {
    **{"face-1 length": "80.005", "face-2 length": "50.005", "face-3 length": "30.005"},
    **{f"cylinder-1 {place}": "38.010" for place in "ab"},
    **{f"cylinder-3 {place}": "36.020" for place in "ab"},
}
"""Of the second side, diameters 10 µm and lengths 5 µm too large."""
JOB_OF_SIDES = """
[part]
name = "shaft"
dxf = "shaft.dxf"
serial = "0017"
[[setups]]
name = "side1"
zero_at_z_mm = 0.0
programs = { dialect = "fanuc-lathe", finish = "first.nc" }
tools = [{ number = 1, nose_radius_mm = 0.8, name = "roughing and finishing" }]
[[setups]]
name = "side2"
zero_at_z_mm = -80.0
flipped = true
programs = { dialect = "fanuc-lathe", finish = "second.nc" }
tools = [{ number = 2, nose_radius_mm = 0.8 }, { number = 4, nose_radius_mm = 0.4 }]
[gauging]
readings = "readings.csv"
"""


def drawing_of_sides() -> bytes:
    """The shaft of two sides as a DXF drawing: its half section, x along the axis."""
    document = new_drawing("R2010", units=4)
    space = document.modelspace()
    back = [(-80.0, 11.0), (-80.0, 17.0)]
    front = [(-78, 19), (-50, 19), (-50, 26), (-30, 26), (-30, 18), (-3, 18), (0, 15), (0, 4), (-62, 4), (-62, 10)]
    inside = [(-62, 10), (-79, 10), (-80, 11)]
    for points in (back, front, inside):
        for start, end in pairwise(points):
            space.add_line(start, end)
    space.add_arc((-78, 17), 2, 90, 180)
    text = StringIO()
    document.write(text)
    return text.getvalue().encode()


def of_sides(caller: Caller, **stated: Any) -> dict[str, Any]:
    """The part of two set-ups, the second with two tools."""
    drawing, second = (
        hand_over(caller, *one)["sha256"] for one in (("shaft.dxf", drawing_of_sides()), ("second.nc", SIDES[1]))
    )
    then = {"program": second, "nose_radius_mm": 0.8, "tool": 2, "zero_at_z_mm": -80.0, "flipped": True}
    then |= {"tools": [{"number": 4, "nose_radius_mm": 0.4}], **stated}
    first = {"tool": 1, "tool_name": "roughing and finishing", "zero_at_z_mm": 0.0, "drawing": drawing}
    return part_of(caller, SIDES[0], "first.nc", **first, then=[then])


def test_a_part_of_two_set_ups_is_corrected_as_by_its_job_and_the_next_one_on_top(
    service: Running, tmp_path: Path
) -> None:
    """By hand: the second side is 10 µm too thick and its faces stand 5 µm proud, so its tool goes 10 µm inwards in
    diameter and 5 µm towards the chuck; the part after that, as far off, takes as much again.
    """
    otto = service.signed_in("operator")
    part = of_sides(otto)
    seen = otto.post("by-hand/part", part).json()
    assert seen["problem"] is None, seen
    assert seen["tools"] == ["side1: T1", "side2: T2", "side2: T4"]
    made = corrected(otto, part, measured(OF_SIDES))
    first, second = made["to_run"]
    assert (first["setup"], first["entered"], first["program"], first["given"]) == (
        "side1",
        [],
        "corrected-side1.nc",
        False,
    )
    assert (second["setup"], second["program"], second["given"]) == ("side2", "second.nc", True)
    assert second["entered"][0].startswith("T2 wear X −0.0100 mm (diameter), Z −0.0050"), second
    assert made["ways"] == [] and made["kept"] and len(made["pictures"]) == 2
    assert {one["cut_by"] for one in made["features"]} == {"side1: T1", "side2: T2"}

    for name, content in (("first.nc", SIDES[0]), ("second.nc", SIDES[1]), ("shaft.dxf", drawing_of_sides())):
        (tmp_path / name).write_bytes(content)
    (tmp_path / "job.toml").write_text(JOB_OF_SIDES)
    (tmp_path / "readings.csv").write_bytes(file_of(otto, made, "readings.csv"))
    compensate_part(tmp_path / "job.toml", tmp_path / "out", store=False)
    by_job = (tmp_path / "out" / "corrected-side1.nc").read_bytes()
    assert moves(file_of(otto, made, "corrected-side1.nc")) == moves(by_job) != moves(SIDES[0])

    (before,) = otto.post("by-hand/part", part).json()["made_before"]
    assert (before["serial"], before["ways"], before["tool"]) == ("0017", [], "T1, T2")
    answer = otto.post("by-hand/correction", {"part": part, "measured": measured(OF_SIDES, serial="0018")})
    assert problem(answer) == "CMP-CUT-WITH"
    stated = {"serial": "0018", "cut_with": before["id"], "made_before": [before["id"]]}
    after = corrected(otto, part, measured(OF_SIDES, **stated))
    assert after["to_run"][1]["entered"][0].startswith("T2 wear X −0.0100 mm (diameter), Z −0.0050")
    assert any(
        "X −10.0 µm (radius), Z −10.0 µm, of which X −5.0 µm, Z −5.0 µm were in force" in one for one in after["notes"]
    )


@pytest.mark.parametrize(
    ("stated", "code"),
    [({"flipped": False}, "SET-MIRROR"), ({"zero_at_z_mm": None}, "SET-DATUM"), ({"nose_radius_mm": 0.2}, "SET-CUTS")],
)
def test_a_set_up_that_cannot_be_as_stated_is_refused(service: Running, stated: dict[str, Any], code: str) -> None:
    otto = service.signed_in("operator")
    assert otto.post("by-hand/part", of_sides(otto, **stated)).json()["problem"]["code"] == code


def test_the_question_is_of_the_set_up_whose_program_it_is_about(service: Running) -> None:
    otto = service.signed_in("operator")
    second = hand_over(otto, "second.nc", SIDES[1].replace(b"G21 ", b""))["sha256"]
    question = otto.post("by-hand/part", of_sides(otto, program=second)).json()["question"]
    assert (question["about"], question["program"]) == ("unit", 1)
    without = {**of_sides(otto), "drawing": ""}
    assert otto.post("by-hand/part", without).json()["problem"]["code"] == "SRV-REQUEST"


PLATE = EXAMPLES / "plate"
FEATURES = {f"B{k}": f"bore{k + 1}" for k in range(6)} | {"S0": "boss1", "S1": "boss2"}
FEATURES |= {"top": "face1", "step": "face3", "floor": "face4"}
"""The features that the plate's program shows, by the names of its measurement."""


def milled_part_of(caller: Caller, inch: bool = False) -> dict[str, Any]:
    """The plate's program as a request; in inches every length of it divided by 25.4."""
    text = (PLATE / "finish.nc").read_text()
    if inch:
        lengths = re.compile(r"(?<=[XYZIJRF])-?\d+\.\d*")
        text = lengths.sub(lambda found: f"{float(found.group()) / 25.4:.6f}", text.replace("G21", "G20"))
    program = hand_over(caller, "finish.nc", text.encode())["sha256"]
    return {"program": program, "dialect": "fanuc-mill", "name": "plate"}


def test_a_milled_part_is_answered_as_by_its_job_on_the_command_line(service: Running, tmp_path: Path) -> None:
    otto = service.signed_in("operator")
    part = milled_part_of(otto)
    assert otto.post("by-hand/milled", {**part, "dialect": None}).json()["question"]["about"] == "dialect"
    seen = otto.post("by-hand/milled", part).json()
    assert {one["name"] for one in seen["features"]} >= set(FEATURES.values())
    assert {"bore1 diameter", "bore1 x", "bore1 y", "face1 z"} <= {one["name"] for one in seen["sizes"]}
    measured = {"file": hand_over(otto, "part-1.dmo", (PLATE / "part-1.dmo").read_bytes())["sha256"], "names": FEATURES}
    answer = otto.post("by-hand/entries", {"part": part, "measured": measured})
    assert answer.status_code == 201, answer.text
    made = answer.json()

    for name in ("plate.toml", "finish.nc", "part-1.dmo"):
        (tmp_path / name).write_bytes((PLATE / name).read_bytes())
    job = (tmp_path / "plate.toml").read_text().replace("measuring_u_um = 0.8\n", "")
    (tmp_path / "plate.toml").write_text(job)
    read = read_milled(tmp_path / "plate.toml")
    found = entries_for_next_part(read)
    *by_command, rms = entry_lines(read, found)
    changes = {line.partition(" (±")[0] for line in made["entries"]}
    assert changes == {line.partition(" (±")[0] for line in by_command}, (made["entries"], by_command)
    assert made["rms"] == rms

    # The next part, off by as much again: what was entered is known by the record
    stated = {**measured, "entered": next(one["sha256"] for one in made["files"] if one["name"] == "entries.json")}
    again = problem(otto.post("by-hand/entries", {"part": {**part, "name": "other"}, "measured": stated}))
    assert again == "MIL-RECORD"


@pytest.mark.parametrize(
    ("value", "line"),
    [
        ("11,980", r"Werkzeug 2, Radius \(D22\): -0,01[45] mm dazu \(± 0,00\d\d mm\)"),
        ("0,471654", r"Werkzeug 2, Radius \(D22\): -0,000[56] in dazu \(± 0,000\d+ in\)"),
    ],
    ids=["mm", "inch"],
)
def test_typed_values_of_a_milled_part_are_taken_with_their_tolerances(
    service: Running, value: str, line: str, request: pytest.FixtureRequest
) -> None:
    """By hand: bores of 12 H7 (0 to +18 µm), read 20 µm too small and brought to the middle of the zone, need a path
    29 µm wider in diameter: a radius 14.5 µm smaller at the control, 0.00057 inch.
    """
    otto = service.signed_in("operator")
    part, values = milled_part_of(otto, "inch" in request.node.name), {"bore1 diameter": [value, value]}
    body = {"part": part, "measured": {"values": values, "tolerances": {"bore1 diameter": "H7"}}}
    made = otto.post("by-hand/entries", body, params={"language": "de"}).json()
    (entered,) = made["entries"]
    assert re.fullmatch(line, entered), made
    answer = problem(otto.post("by-hand/entries", {**body, "measured": {"values": {"bore9 diameter": ["1"]}}}))
    assert answer == "MSR-FEATURE"


def test_a_milled_part_with_a_serial_number_is_kept_for_series_and_certificate(service: Running) -> None:
    """Bores of 12 H7 (0 to +18 µm): 11.980 does not conform, 12.009 ± 4 µm does. What had been entered before the
    second part is no correction in the store: its certificate states no cut, and not that it was cut as programmed.
    """
    otto = service.signed_in("operator")
    part, tolerances = milled_part_of(otto), {"bore1 diameter": "H7"}

    def entered(value: str, serial: str, record: str = "") -> dict[str, Any]:
        read = {"values": {"bore1 diameter": [value, value]}, "tolerances": tolerances, "expanded_uncertainty_um": 4.0}
        measured = {**read, "serial": serial, "entered": record}
        answer = otto.post("by-hand/entries", {"part": part, "measured": measured})
        assert answer.status_code == 201, answer.text
        return dict(answer.json())

    assert not entered("11.980", "")["kept"] and not find(service.store, Inspection)
    made = entered("11.980", "M1")
    assert made["kept"] and entered("11.980", "M1")["kept"] and len(find(service.store, Inspection)) == 1
    first = certify_part(service.store, "M1", "plate")
    assert first.outcome == "does not conform" and any(one.identity == part["program"] for one in first.in_force)
    record = next(one["sha256"] for one in made["files"] if one["name"] == "entries.json")
    assert entered("12.009", "M2", record)["kept"]
    second = certify_part(service.store, "M2", "plate")
    assert second.outcome == "conforms" and not second.in_force
    assert any("no finish cut" in str(one) for one in second.missing)
    assert [one["characteristic"] for one in otto.get("series", params={"part_type": "plate"}).json()["items"]] == [
        "bore1 diameter"
    ]


def test_the_temperature_of_a_part_is_kept_with_its_values(service: Running) -> None:
    otto = service.signed_in("operator")
    corrected(otto, part_of(otto), measured(temperature_c=24.5))
    (kept,) = find(service.store, Inspection)
    assert {one.temperature_c for one in kept.value.readings} == {24.5}
    assert correction(otto, part_of(otto), measured(temperature_c=500.0)).status_code == 422
