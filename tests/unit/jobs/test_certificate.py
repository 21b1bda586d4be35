"""Certificates of parts: what is not known is not certified; what was in force stands there by its hash."""

import hashlib
import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Literal

import pytest

from tests.loops.test_cut_with import FIRST, SECOND, correct
from tests.support.cli import run
from tests.support.records import TURNED
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import BothInspections, Inspection, MachineStood, Reading
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.part import Part, PartType
from trueloop.domain.proposal import ModelDecision
from trueloop.domain.record import Correction, ProgramText
from trueloop.domain.tool import Edge, Machine, Setting, Tool
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.jobs.monitor.certificate import certify_part, write_certificate
from trueloop.jobs.store.codec import store_codec
from trueloop.report.monitor.certificate import CertificateShape, CertifiedShape, hash_of
from trueloop.storage.store import Store, find, keep, open_store

AT = datetime(2026, 3, 1, 8, tzinfo=UTC)
PART = Part(PartType("SHAFT"), "7")
JOURNAL = Reading("journal", Quantity.DIAMETER, 24.004, 24.0, 23.98, 24.02, standard_u=0.001, temperature_c=20.2)


def inspected(*readings: Reading, device: str = "CMM 3", hours: float = 5.0, part: Part = PART) -> Inspection:
    at = AT + timedelta(hours=hours)
    return Inspection(part, "readings", f"file {hours:g} {device}", len(readings), readings, device, measured_at=at)


def store_of(*values: object) -> Store:
    store = open_store("sqlite://", create=True)
    keep(store, values)
    return store


def certified(*values: object, u_um: float | None = None) -> CertificateShape:
    return certify_part(store_of(*values), "7", None, u_um, "K. Roth")


def only(shown: CertificateShape) -> CertifiedShape:
    (one,) = shown.characteristics
    return one


def test_a_value_that_is_proven_inside_is_certified_with_its_device_time_and_temperature() -> None:
    shown = certified(inspected(JOURNAL))
    one = only(shown)
    assert (shown.outcome, one.verdict, one.certified, one.missing, one.remarks) == ("conforms", "in", True, [], [])
    assert (one.actual, one.expanded_u, one.device, one.temperature_c) == (24.004, 0.002, "CMM 3", 20.2)
    assert one.measured_at == AT + timedelta(hours=5)


def test_each_size_has_the_device_that_measured_it(tmp_path: Path) -> None:
    file = tmp_path / "part.csv"
    rows = (
        "journal,24,23.98,24.02,24,CMM 1\nseat,30,29.98,30.02,30,MIC 2\nbore,9,8.98,9.02,9,\ncone,9,8.98,9.02,9,probe\n"
    )
    head = "part name,serial,characteristic,nominal,lower limit,upper limit,actual,device\n"
    file.write_text(head + "".join(f"SHAFT,7,{row}\n" for row in rows.splitlines()))
    (inspection,) = read_measured_file(file, StatedFacts(unit="mm")).inspections
    before = replace(inspection, devices={})
    assert len(find(store_of(before, inspection), Inspection)) == 1  # the file read before devices were kept
    shown = {one.characteristic: one for one in certified(inspection, u_um=1.0).characteristics}
    assert {name: one.device for name, one in shown.items()} == {
        "journal": "CMM 1",
        "seat": "MIC 2",
        "bore": "",
        "cone": "probe",
    }
    assert {name for name, one in shown.items() if "the device is not stated" in one.missing} == {"bore"}


@pytest.mark.parametrize(
    ("actual", "verdict", "outcome"),
    [
        (24.0184 - 1e-4, "in", "conforms"),
        (24.0184 + 1e-4, "undecided", "not certified"),
        (24.0216 + 1e-4, "out", "does not conform"),
        (23.9784 - 1e-4, "out", "does not conform"),
    ],
)
def test_the_guard_band_of_1_645_u_decides(actual: float, verdict: str, outcome: str) -> None:
    shown = certified(inspected(replace(JOURNAL, actual=actual)))
    assert (only(shown).verdict, shown.outcome) == (verdict, outcome)


@pytest.mark.parametrize(
    ("inspection", "lacks"),
    [
        (inspected(replace(JOURNAL, standard_u=None)), "no uncertainty is stated"),
        (inspected(replace(JOURNAL, lower_limit=None, upper_limit=None)), "no limit is stated"),
        (inspected(JOURNAL, device=""), "the device is not stated"),
    ],
)
def test_what_is_not_known_is_not_certified(inspection: Inspection, lacks: str) -> None:
    shown = certified(inspection)
    assert (shown.outcome, only(shown).certified, only(shown).missing) == ("not certified", False, [lacks])


def test_an_uncertainty_stated_with_the_certificate_counts_and_is_said() -> None:
    shown = certified(inspected(replace(JOURNAL, standard_u=None)), u_um=1.5)
    assert (shown.outcome, only(shown).expanded_u, shown.stated_u_um) == ("conforms", 0.003, 1.5)
    assert only(certified(inspected(JOURNAL), u_um=1.5)).expanded_u == 0.002, "what a reading states counts more"


def test_what_other_parts_were_measured_for_is_missing_on_this_one() -> None:
    other = inspected(replace(JOURNAL, characteristic="seat"), part=Part(PartType("SHAFT"), "8"))
    shown = certified(inspected(JOURNAL), other)
    seat = next(one for one in shown.characteristics if one.characteristic == "seat")
    assert seat.missing == ["it was not measured on this part"] and shown.outcome == "not certified"


def test_repeats_are_averaged_u_holds_their_spread_and_a_temperature_off_20_degrees_is_said() -> None:
    readings = [replace(JOURNAL, actual=24.0 + k / 1000, repeat=k, temperature_c=24.0) for k in (1, 2, 6)]
    one = only(certified(inspected(*readings)))
    assert (one.actual, one.repeats, one.verdict) == (24.003, 3, "in")
    assert one.expanded_u == pytest.approx(2 * (0.001**2 + (0.002**2 + 0.001**2 + 0.003**2) / 2) ** 0.5, abs=1e-7)
    assert one.remarks == ["measured at 24.0 °C, not at 20 °C"]


@pytest.mark.parametrize(
    ("actuals", "verdict", "away"),
    [
        ((24.04, 23.96), "out", "+40.0"),
        ((24.0, 24.0, 24.023), "out", "+15.3"),
        ((24.0, 24.0, 24.0, 23.979), "undecided", "−15.8"),
        ((24.015, 23.985), "undecided", ""),  # each is inside; by how far they scatter, their mean is not proven
    ],
)
def test_the_worst_of_several_readings_is_judged(actuals: tuple[float, ...], verdict: str, away: str) -> None:
    """The limits are 23.98 and 24.02, 1.645 u is 1.6 µm: by hand."""
    shown = certified(inspected(*(replace(JOURNAL, actual=actual, repeat=k) for k, actual in enumerate(actuals, 1))))
    one = only(shown)
    outcome = "does not conform" if verdict == "out" else "not certified"
    assert (one.verdict, one.certified, shown.outcome) == (verdict, False, outcome)
    said = [f"judged by the worst of {len(actuals)} readings, {away} µm from their mean"] if away else []
    assert one.remarks == said


def test_another_measurement_that_is_out_forbids_to_certify_until_the_part_is_cut_again() -> None:
    out = inspected(replace(JOURNAL, actual=24.03), device="micrometer 114", hours=4)
    shown = certified(out, inspected(JOURNAL, hours=5))
    assert (only(shown).verdict, shown.outcome) == ("in", "not certified")
    assert only(shown).missing == ["another measurement is outside the limits: micrometer 114, 2026-03-01 12:00"]
    first, again = _cut(), replace(_cut(), at=AT + timedelta(hours=4.5))
    assert first.identity != again.identity
    assert certified(first, again, out, InspectionLink(out.identity, first.identity), inspected(JOURNAL)).outcome == (
        "conforms"
    )


def test_a_signed_value_of_a_form_is_not_certified_by_an_upper_limit_alone() -> None:
    profile = replace(JOURNAL, quantity=Quantity.FORM, actual=-0.03, nominal=0.0, lower_limit=None, upper_limit=0.02)
    shown = certified(inspected(profile))
    assert (only(shown).verdict, shown.outcome) == (None, "not certified")
    assert only(shown).missing == ["a form below 0 is a signed deviation: both limits are needed"]
    assert certified(inspected(replace(profile, lower_limit=-0.025))).outcome == "does not conform"
    assert certified(inspected(replace(profile, actual=0.03))).outcome == "does not conform"


def _cut() -> Cut:
    setting = Setting(Edge(Tool(3, "T3"), "DNMG", "1"), AT - timedelta(hours=1))
    return Cut(PART, Stage.FINISH, setting, Machine("Lathe", "0815"), "a" * 64, at=AT)


@pytest.mark.parametrize(
    ("device", "ball_mm", "frame", "stated"),
    [
        ("", 0.0, "part", False),
        ("", 1.0, "part", True),
        ("CMM 3", 1.0, "part", False),
        ("Renishaw OMP40", 1.0, "machine", True),
        ("probe of the machine tool", 1.0, "part", True),
        ("Zeiss Prismo, probe VAST", 1.0, "part", False),
    ],
)
def test_only_the_probe_of_the_machine_is_said_not_to_see_its_errors(
    device: str, ball_mm: float, frame: Literal["part", "machine"], stated: bool
) -> None:
    cut = _cut()
    one = replace(inspected(JOURNAL, device=device, hours=9), ball_radius_mm=ball_mm, frame=frame)
    shown = only(certified(cut, one, InspectionLink(one.identity, cut.identity)))
    assert any("does not see its own errors" in remark for remark in shown.remarks) is stated


def test_the_released_part_counts_and_an_inspection_after_an_earlier_cut_does_not() -> None:
    cut, early = _cut(), replace(_cut(), stage=Stage.SEMIFINISH, at=AT - timedelta(hours=2))
    on_machine = inspected(replace(JOURNAL, actual=24.009), device="probe", hours=9)
    before = inspected(replace(JOURNAL, actual=24.4), device="probe", hours=-1)
    links = (InspectionLink(on_machine.identity, cut.identity), InspectionLink(before.identity, early.identity))
    alone = only(certified(cut, early, on_machine, before, *links))
    assert alone.actual == 24.009
    assert "measured on the machine that cut it, which does not see its own errors" in alone.remarks
    cmm = inspected(JOURNAL, hours=5)
    shown = certified(cut, early, on_machine, before, cmm, *links, InspectionLink(cmm.identity, cut.identity, True))
    assert (only(shown).actual, only(shown).device, only(shown).remarks) == (24.004, "CMM 3", [])


def test_what_was_in_force_stands_by_its_hash_and_what_is_not_known_is_said() -> None:
    stood = MachineStood((0.0, 0.0, 0.0), ((0.0, 0.0, 0.0),))
    both = BothInspections(PART, Machine("Lathe", "0815"), ("m",), ("c",), stood, stood, "b" * 64, compensated=True)
    accepted = ModelDecision("b" * 64, "accepted", "K. Roth", AT)
    shown = certified(inspected(JOURNAL), _cut(), ProgramText("a" * 64, b"G1"), both, accepted)
    known = {one.what: one for one in shown.in_force}
    assert (known["program"].identity, known["program"].words) == ("a" * 64, "its text is kept")
    assert (known["model"].identity, known["model"].words) == ("b" * 64, "accepted by K. Roth at 2026-03-01 08:00")
    assert known["machine"].identity == "Lathe 0815" and known["edge"].words == "set at 2026-03-01 07:00"
    assert known["correction"].words == "none: cut as programmed" and shown.missing == []
    bare = certified(inspected(JOURNAL))
    assert bare.in_force == [] and len(bare.missing) == 2
    lost = certified(inspected(JOURNAL), replace(_cut(), correction="c1", program_sha256="", setting=None))
    assert lost.missing[:3] == [
        "the program that ran is not known",
        "the edge that cut is not known",
        "correction c1 is not in the store",
    ]


def test_the_machine_s_model_of_the_correction_that_cut_is_known_to_have_been_in_force() -> None:
    model = "b" * 64
    inputs = {"job.toml": "0" * 64, "model.json": model}
    record = replace(TURNED, inputs_sha256=inputs, options={"machine": {"model": model}}, tool_offset=None)
    cut = replace(_cut(), correction=record.id)
    shown = certified(inspected(JOURNAL), cut, Correction(record, {}, None), ModelDecision(model, "accepted", "K", AT))
    assert [(one.identity, one.words) for one in shown.in_force if one.what == "model"] == [
        (model, "accepted by K at 2026-03-01 08:00")
    ]
    assert [one.words for one in shown.in_force if one.what == "input of the correction"] == ["job.toml"]
    assert shown.missing == []


def test_an_inspection_by_a_named_device_is_not_said_to_be_of_the_machine() -> None:
    cut = _cut()
    cmm = inspected(JOURNAL, device="CMM 7")
    one = only(certified(cut, cmm, InspectionLink(cmm.identity, cut.identity)))
    assert (one.device, one.remarks) == ("CMM 7", [])


def test_a_coordinate_without_limits_is_not_asked_for() -> None:
    """A measuring machine reports where a circle is beside its diameter, which alone has limits."""
    place = Reading("journal z", Quantity.POSITION, -12.001, -12.0, None, None, standard_u=0.001)
    shown = certified(inspected(JOURNAL, place))
    assert only(shown).characteristic == "journal" and shown.outcome == "conforms"


def test_what_is_said_to_have_been_in_force_is_what_was(tmp_path: Path) -> None:
    """Two parts by contour: no tool offset is stated, though either record proposes one; then one by wear entered."""
    db = str(tmp_path / "m.db")
    run("db", "init", db)
    first = correct(tmp_path, 1, FIRST, "contour", db=db)
    record = first.correction.record.id
    correct(tmp_path, 2, SECOND, "contour", f'cut_with = "{record}"', db=db)
    by_wear = f'cut_with = "{record}"\ncut_by = "wear"'
    correct(tmp_path, 3, (0.006, 0.006, 0.006, 0.006), "offset", by_wear, db=db)
    store = open_store(db, codec=store_codec())
    found = {serial: {one.what: one for one in certify_part(store, serial, None).in_force} for serial in "123"}
    corrected = (tmp_path / "o1" / "corrected.nc").read_bytes()
    assert found["1"]["correction"].words == "none: cut as programmed" and "tool offset" not in found["1"]
    assert found["2"]["correction"].identity == record and "tool offset" not in found["2"]
    assert found["2"]["program"].identity == hashlib.sha256(corrected).hexdigest()
    assert (
        found["3"]["tool offset"].words
        == "tool 3: X −25.0 µm on the radius, −50.0 µm on the diameter, Z +0.0 µm (X ± 5.6 µm, Z not determined by "
        "what was measured)"
    )
    assert found["3"]["program"].identity == hashlib.sha256((tmp_path / "f.nc").read_bytes()).hexdigest()


DRAWING = """device = "MIC 2"
[[part.characteristic]]
name = "D30"
quantity = "diameter"
feature = "cylinder-2"
tolerance = "h6"
[[part.characteristic]]
name = "D36"
quantity = "diameter"
feature = "cylinder-1"
tolerance = "±0.1"
[[part.characteristic]]
name = "L30"
quantity = "length"
feature = "face-1"
tolerance = "±0.02"
"""


def test_the_limits_of_the_job_are_those_of_the_certificate(tmp_path: Path) -> None:
    """By hand: 30.050 is out of 30 h6 (29.987 to 30.000), 36.050 inside 36 ± 0.1; the length is not measured. Limits
    of a file, 29.99 to 30.01, do not count beside those: 30.002 with a guard band of 1.6 µm is out."""
    db = str(tmp_path / "m.db")
    run("db", "init", db)
    correct(tmp_path, 1, FIRST, "contour", more=DRAWING, db=db)
    store = open_store(db, codec=store_codec())
    first = certify_part(store, "1", None, 1.0)
    found = {
        one.characteristic: (one.lower_limit, one.upper_limit, one.verdict, one.device) for one in first.characteristics
    }
    assert found == {
        "D30": (29.987, 30.0, "out", "MIC 2"),
        "D36": (35.9, 36.1, "in", "MIC 2"),
        "L30": (29.98, 30.02, None, ""),
    }
    assert [one.missing for one in first.characteristics if one.characteristic == "L30"] == [
        ["it was not measured on this part"]
    ]
    reading = Reading("jr", Quantity.DIAMETER, 30.002, 30.0, 29.99, 30.01, feature="cylinder-2", standard_u=0.001)
    length = Reading("sh", Quantity.LENGTH, 30.01, feature="face-1", other="face-2", standard_u=0.001)
    keep(store, [inspected(reading, length, part=Part(PartType("s"), "2"))])
    second = {
        one.characteristic: (one.upper_limit, one.verdict) for one in certify_part(store, "2", None).characteristics
    }
    assert second == {"D30": (30.0, "out"), "D36": (36.1, None), "L30": (30.02, "in")}


def test_the_hash_is_that_of_the_document_without_it(tmp_path: Path) -> None:
    shown = certified(inspected(JOURNAL))
    json_file, html = write_certificate(shown, tmp_path, "de", "mm")
    content = json.loads(Path(json_file).read_text(encoding="utf-8"))
    said, content["sha256"] = content["sha256"], ""
    plain = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    assert hashlib.sha256(plain.encode()).hexdigest() == said == shown.sha256
    assert said in Path(html).read_text(encoding="utf-8")
    changed = shown.model_copy(update={"serial": "8"})
    assert hash_of(changed) != shown.sha256


def test_parts_that_are_not_known_not_one_or_not_measured_are_refused() -> None:
    twice = (inspected(JOURNAL), inspected(JOURNAL, part=Part(PartType("HUB"), "7")))
    for values in ((), twice, (PART,)):
        with pytest.raises(TrueloopError) as refused:
            certified(*values)
        assert refused.value.code is Code.MON_NONE
    assert certify_part(store_of(*twice), "7", "HUB").part_type == "HUB"
