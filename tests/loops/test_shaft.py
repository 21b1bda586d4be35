"""Six diameters by micrometer, and nothing else, to a corrected program: the example, as its user has it."""

import re
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke, run
from tests.support.gauged import EXAMPLES, shaft_with
from trueloop.errors import Code, TrueloopError
from trueloop.formats.record_file import read_record
from trueloop.jobs.measure.measured import map_table
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.loops.turned.provenance import CODEC
from trueloop.nc.program.program import read_program
from trueloop.turned.touches.error_vectors import ErrorVectors

SIX = (EXAMPLES / "shaft" / "readings.csv").read_text(encoding="utf-8")
HEADER = "feature,z_mm,diameter_mm\n"
ALL_TOO_LARGE = (
    "seat-44,-105,44.020\nseat-44,-85,44.020\nseat-36,-60,36.020\nseat-30,-20,30.020\njournal-24,-5,24.020\n"
)


def corrected(folder: Path, readings: str, more: str = "", table: str = "gauging") -> Correction:
    return compensate(read_job(shaft_with(folder, readings, more, table)).inputs)


def x_words(program: bytes) -> list[float]:
    return [float(word) for word in re.findall(rb"^(?:G01 )?X([\d.]+)", program, re.MULTILINE)]


def test_readings_become_points_with_half_the_deviation_of_the_diameter(tmp_path: Path) -> None:
    inputs = read_job(shaft_with(tmp_path, SIX)).inputs
    np.testing.assert_allclose(1e3 * inputs.touches.error_mm, [15.5, 13.5, 12.5, 11.0, 8.0, 6.5], atol=1e-6)
    np.testing.assert_allclose(1e3 * inputs.touches.standard_u_mm, 1.0, atol=1e-9)
    (inspection,) = inputs.inspections
    assert (inspection.count, inspection.operator, inspection.measured) == (6, "M. Keller", "readings")


@pytest.mark.parametrize(("readings", "sign"), [("44.020", -1.0), ("43.980", 1.0)])
def test_a_part_that_is_too_large_gets_a_smaller_offset_and_the_reverse(
    tmp_path: Path, readings: str, sign: float
) -> None:
    """20 µm on every diameter, too large or too small: the offset takes out 10 µm on the radius, 20 on the diameter."""
    text = HEADER + ALL_TOO_LARGE.replace(".020", "." + readings.partition(".")[2])
    if sign > 0:
        text = text.replace("44.", "43.").replace("36.", "35.").replace("30.", "29.").replace(",24.", ",23.")
    correction = corrected(tmp_path, text)
    assert correction.decision.offset_is_enough
    assert 1e3 * correction.decision.offset_mm[0] == pytest.approx(sign * 10.0, abs=1e-6)
    assert correction.decision.offset_mm[1] == 0.0
    assert f"wear X {'−' if sign < 0 else '+'}0.020 (diameter)" in correction.wear.words


def test_a_taper_moves_the_contour_towards_the_nominal_diameters(tmp_path: Path) -> None:
    """The program's own seat of 44 mm is cut smaller by what the micrometer read, within its uncertainty."""
    correction = corrected(tmp_path, SIX)
    assert not correction.decision.by_offset
    seat = correction.profile.names.index("seat-44")
    shift = correction.model.curves[seat].value_mm(np.array([7.0, 27.0]))
    np.testing.assert_allclose(1e3 * shift, [15.5, 13.5], atol=1.0)
    given, written = x_words(correction.source_program), x_words(correction.corrected_program)
    assert written[: len(given)] != given
    assert [x for x in written if 43.0 < x < 45.0] == pytest.approx([44.0 - 2 * 0.0135, 44.0 - 2 * 0.0155], abs=0.002)


def test_what_was_not_measured_says_so(tmp_path: Path) -> None:
    correction = corrected(tmp_path, SIX)
    for name, u_um in (("end-face", (30.0, 45.0)), ("cone", (15.0, 30.0)), ("seat-30", (5.0, 10.0))):
        index = correction.profile.names.index(name)
        middle = np.array([0.5 * correction.profile.features[index].length_mm])
        u = float(correction.next_cut(index, middle).expanded_u_mm[0]) * 1e3
        assert u_um[0] < u < u_um[1], name
    assert correction.model.curves[correction.profile.names.index("end-face")].unsupported


def test_repeats_widen_and_their_number_narrows_the_band_of_a_part(tmp_path: Path) -> None:
    def u_um(readings: str, folder: str) -> float:
        correction = corrected(tmp_path / folder, HEADER + readings)
        seat = correction.profile.names.index("seat-44")
        return float(correction.model.curves[seat].standard_deviation_mm(10.0)[0]) * 1e3

    once = u_um("seat-44,-102,44.020\n", "once")
    scattering = u_um("seat-44,-102,44.010\nseat-44,-102,44.030\n", "two")
    many = u_um("seat-44,-102,44.010\nseat-44,-102,44.030\n" * 8, "many")
    assert once < scattering
    assert many < scattering


@pytest.mark.parametrize("gauge_um", [20.0, 40.0])
def test_an_offset_is_known_no_better_than_six_readings_of_its_gauge_tell(tmp_path: Path, gauge_um: float) -> None:
    """The mean of six diameters of u each has u/√6, on the radius half of it, however well they agree."""
    correction = corrected(tmp_path, SIX.replace("uncertainty_um: 2", f"uncertainty_um: {gauge_um}"))
    assert correction.decision.by_offset
    assert np.all(1e3 * correction.prediction.budget.found_mm > gauge_um / 2 / np.sqrt(6))
    assert np.all(1e3 * correction.prediction.budget.found_mm < np.hypot(gauge_um / 2, 1.0))


@pytest.mark.parametrize("by", ["auto", "contour"])
def test_one_reading_of_a_coarse_gauge_does_not_blind_the_good_ones(tmp_path: Path, by: str) -> None:
    """A calliper on a seat (u = 20 µm) beside six micrometer readings (2 µm): the offset moves by its weight alone."""
    more = f'by = "{by}"\n'
    fine = "\n".join(line + (",2" if line[:1].isalpha() and "," in line else "") for line in SIX.splitlines())
    fine = fine.replace("diameter_mm,2", "diameter_mm,uncertainty_um") + "\n"
    alone = compensate(read_job(shaft_with(tmp_path / "a", fine, more, "compensation")).inputs)
    beside = compensate(
        read_job(shaft_with(tmp_path / "b", fine + "seat-30,-22,30.080,20\n", more, "compensation")).inputs
    )
    assert alone.decision.by_offset is beside.decision.by_offset is False
    moved_um = 1e3 * (beside.decision.offset_mm[0] - alone.decision.offset_mm[0])
    assert moved_um == pytest.approx(-(40.0 - 11.2) / 601, abs=0.02)  # weights 1/u²: 100 to 1, six readings to one


def test_the_record_keeps_every_reading_and_comes_back_equal(tmp_path: Path) -> None:
    job = shaft_with(tmp_path, SIX)
    words = run("compensate", job)
    assert "wear X −0.022 (diameter)" in words
    record = read_record(tmp_path / "out" / "record.json")
    (inspection,) = record.inspections
    assert [one.actual for one in inspection.readings] == [44.031, 44.027, 36.025, 36.022, 30.016, 24.013]
    correction = corrected(tmp_path, SIX)
    assert CODEC.from_json(CODEC.to_json(correction.touches), ErrorVectors) == correction.touches


def test_touches_and_readings_are_corrected_together(tmp_path: Path) -> None:
    """Touches on a seat make its curve, readings those of the others; a touch and a reading in one place are one."""
    touches = "point,feature,nominal_x_mm,nominal_z_mm,error_um\n" + "".join(
        f"{k},seat-44,22,{z},{15 + 0.5 * (-1) ** k}\n" for k, z in enumerate((-108, -102, -96, -90, -84))
    )
    shaft_with(tmp_path, SIX)
    (tmp_path / "touches.csv").write_text(touches)
    both = SIX.replace("seat-44,-105,", "seat-44,-102,")
    inputs = read_job(shaft_with(tmp_path, both, 'touches = "touches.csv"\n')).inputs
    assert [one.measured for one in inputs.inspections] == ["touches", "readings"]
    names = [inputs.profile.names[i] for i in inputs.touches.feature_index]
    assert (names.count("seat-44"), names.count("seat-36")) == (6, 2)
    model = compensate(inputs).model
    assert 1e3 * model.curves[0].value_mm(10.0)[0] == pytest.approx(15.0, abs=0.5)
    assert 1e3 * model.curves[3].value_mm(10.0)[0] == pytest.approx(12.0, abs=1.5)


def test_a_warm_part_is_noted_with_what_that_makes(tmp_path: Path) -> None:
    """44.020 mm of steel, 15 K above 20 °C: 11.5 µm/m/K · 15 · 0.044 = 7.6 µm; at 20.5 °C no word of it."""
    warm, cool = (corrected(tmp_path / str(c), f"# temperature_c: {c}\n" + HEADER + ALL_TOO_LARGE) for c in (35, 20.5))
    (note,) = (str(one) for one in warm.notes if "°C" in str(one))
    assert "5 readings were taken at up to 35.0 °C: seat-44 diameter" in note and "changes by +7.6 µm" in note
    assert not any("°C" in str(one) for one in cool.notes)


def test_a_coarse_gauge_that_repeats_badly_leaves_the_fine_ones_as_they_are(tmp_path: Path) -> None:
    """Two readings of a calliper 200 µm apart, to 80 µm each, beside four of a micrometer to 1 µm: these decide alone,
    as 0.5 µm on the radius of each against √(80² + 141²/2)/2 = 64 µm.
    """
    head = "feature,z_mm,diameter_mm,uncertainty_um\n"
    fine = "".join(f"{row},1\n" for row in ALL_TOO_LARGE.splitlines() if "seat-30" not in row)
    done = corrected(tmp_path, head + fine + "seat-30,-20,30.120,80\nseat-30,-20,29.920,80\n")
    assert 1e3 * done.decision.offset_mm[0] == pytest.approx(-10.0, abs=0.01)
    assert 1e3 * np.sort(done.touches.standard_u_mm) == pytest.approx([0.5, 0.5, 0.5, 0.5, 64.03], abs=0.01)


def test_readings_too_vague_for_any_offset_are_refused(tmp_path: Path) -> None:
    """Five diameters to 100 µm: 50 µm each on the radius, 22 µm all together, over the limit of 10 µm."""
    vague = "# uncertainty_um: 100\n" + HEADER + ALL_TOO_LARGE
    with pytest.raises(TrueloopError, match=r"the best of 5 measurements is known to 50\.0 µm") as refused:
        corrected(tmp_path / "1", vague)
    assert refused.value.code is Code.CMP_SCATTER
    far = vague.replace("44.020", "44.220").replace("36.020", "36.220").replace("30.020", "30.220")
    assert not corrected(tmp_path / "2", far).decision.offset_is_enough
    known = corrected(tmp_path / "3", vague, "max_scatter_um = 51\n", "compensation")
    assert known.decision.offset_mm[0] == pytest.approx(-0.010, abs=1e-6)


@pytest.mark.parametrize("touched", ["", "a,shoulder-2,21,-80,0\nb,end-face,10,0,0\n"])
def test_touches_on_faces_take_nothing_from_the_diameters(tmp_path: Path, touched: str) -> None:
    """Seats of 44 and 36 mm 30 µm too large, the others 20: written that much smaller, whether faces are touched or
    not.
    """
    readings = ALL_TOO_LARGE.replace("44.020", "44.030").replace("36.020", "36.030")
    more = 'touches = "touches.csv"\n' if touched else ""
    job = shaft_with(tmp_path, HEADER + readings, more)
    (tmp_path / "touches.csv").write_text("point,feature,nominal_x_mm,nominal_z_mm,error_um\n" + touched)
    job.write_text(job.read_text().replace("[compensation]\n", '[compensation]\nby = "contour"\n'))
    correction = compensate(read_job(job).inputs)
    programs = correction.source_program, correction.corrected_program
    names = b"(SEAT 44)", b"(SEAT 36)", b"(JOURNAL 24)"
    given, written = ([of_line(one, name)[0] for name in names] for one in programs)
    assert np.subtract(given, written) == pytest.approx([0.015, 0.015, 0.010], abs=0.001)
    assert correction.decision.offset_mm[0] == pytest.approx(-0.013, abs=1e-6)  # the mean of the five


def test_readings_older_than_the_limit_are_refused(tmp_path: Path) -> None:
    day_old = (datetime.now(UTC) - timedelta(hours=30)).isoformat()
    job = shaft_with(tmp_path, SIX.replace("2026-11-20 09:40+01:00", day_old))
    job.write_text(job.read_text().replace("max_age_hours = 1e6", "max_age_hours = 24.0"))
    with pytest.raises(TrueloopError) as caught:
        compensate(read_job(job).inputs)
    assert caught.value.code is Code.CMP_AGE


def test_one_of_several_parts_is_chosen_by_its_serial_number(tmp_path: Path) -> None:
    two = "serial,feature,z_mm,diameter_mm\nA1,seat-44,-85,44.020\nA2,seat-44,-85,44.040\n"
    chosen = read_job(shaft_with(tmp_path, two, 'serial = "A2"\n', "part")).inputs
    np.testing.assert_allclose(chosen.touches.error_mm, [0.020], atol=1e-9)
    with pytest.raises(TrueloopError) as caught:
        read_job(shaft_with(tmp_path, two))
    assert caught.value.code is Code.MSR_SERIAL


@pytest.mark.parametrize(("serial", "error_mm"), [("A1", 0.0155), ("", None)])
def test_pieces_of_a_file_are_never_averaged(serial: str, error_mm: float | None, tmp_path: Path) -> None:
    """Ø 44.031 of piece A1, then Ø 44.051 of the next, which has no serial number: 15.5 µm on the radius, not 20.5."""
    lines = ["K0100 1", "K1002 SHAFT", "K2001/1 1", "K2002/1 Durchmesser 44", "K2101/1 44", "K2142/1 mm"]
    values = ["44.031\x140\x1419.04.2024/19:08:00", "K0014/0 A1", "44.051\x140\x1419.04.2024/19:11:00"]
    job = shaft_with(tmp_path, SIX, f'serial = "{serial}"\n', "part")
    (tmp_path / "two.dfq").write_text("\n".join([*lines, *values]) + "\n")
    job.write_text(job.read_text().replace("readings.csv", "two.dfq"))
    if error_mm is not None:
        np.testing.assert_allclose(read_job(job).inputs.touches.error_mm, [error_mm], atol=1e-9)
        return
    with pytest.raises(TrueloopError, match="inspections 1 and 2 of the file both hold 'Durchmesser 44'") as caught:
        read_job(job)
    assert caught.value.code is Code.MSR_SERIAL and "--run 2 -o one.csv" in caught.value.hint


@pytest.mark.parametrize(
    ("first", "second", "code"), [("A1", "A2", Code.MSR_SERIAL), ("A1", "A1", Code.MSR_VALUE), ("", "A2", None)]
)
def test_files_of_two_parts_or_of_one_content_are_not_read_as_one_part(
    first: str, second: str, code: Code | None, tmp_path: Path
) -> None:
    row = f"{HEADER}seat-44,-105,44.031\n"
    job = shaft_with(tmp_path, f"# serial: {first}\n{row}")
    other = row if first == second else row.replace("-105", "-85")
    (tmp_path / "other.csv").write_text(f"# serial: {second}\n{other}")
    job.write_text(job.read_text().replace('readings = "readings.csv"', 'readings = ["readings.csv", "other.csv"]'))
    if code is None:
        assert len(read_job(job).inputs.touches.point) == 2
        return
    with pytest.raises(TrueloopError) as caught:
        read_job(job)
    assert caught.value.code is code and (caught.value.place.file or "").endswith("other.csv")


def test_nominal_and_actual_values_that_are_exchanged_are_refused_and_the_named_columns_corrected(
    tmp_path: Path,
) -> None:
    """Diameters 15 µm too large read as exact ones of other nominal sizes would be left as they are."""
    head = "characteristic;quantity;nominal;actual [mm]\n"
    rows = "".join(f"{name};diameter;{size + 0.015};{size}\n" for name, size in (("seat-44", 44), ("seat-36", 36)))
    job = shaft_with(tmp_path, head + rows)
    with pytest.raises(
        TrueloopError, match=r"2 readings have another nominal .* the actual ones are the contour's"
    ) as no:
        read_job(job)
    assert no.value.code is Code.MSR_NOMINAL and no.value.place.line == 2
    (tmp_path / "readings.csv").write_text(head + rows.replace(";44\n", ";44.0004\n"))
    assert any("a correction counts from the contour" in note for note in read_job(job).inputs.notes), "0.4 µm off"
    (tmp_path / "readings.csv").write_text(head + rows)
    names = {"nominal": ("actual [mm]",), "actual": ("nominal",)}
    map_table(tmp_path / "readings.csv", tmp_path / "map.toml", given=names)
    job.write_text(job.read_text().replace("[gauging]", '[gauging]\nreadings_mapping = "map.toml"'))
    np.testing.assert_allclose(read_job(job).inputs.touches.error_mm, [0.0075, 0.0075], atol=1e-9)


@pytest.mark.parametrize(
    ("columns", "row", "said"),
    [
        (
            "z_mm,diameter_mm",
            "seat-44,105,44.02",
            "z 105 mm is not on it, which goes from -112 to -80 mm; z -105 mm is on",
        ),
        ("nominal,diameter_mm", "seat-44,44.1,44", "as the actual one is: are the two exchanged?"),
        ("angle_deg", "cone,22.62", "0.5 times it fits: the included angle of a cone?"),
    ],
)
def test_a_value_that_is_not_its_feature_s_is_listed_with_the_slip_that_explains_it(
    columns: str, row: str, said: str, tmp_path: Path
) -> None:
    job = shaft_with(tmp_path, f"feature,{columns}\n{row}\n")
    listed, refused = invoke("measure", "read", tmp_path / "readings.csv", "--job", job, status=1).stdout.split(
        "MSR-PART"
    )
    assert said in listed and said in refused


def test_one_reading_corrects_its_feature_and_says_what_is_not_known(tmp_path: Path) -> None:
    correction = corrected(tmp_path, f"{HEADER}seat-36,-60,36.020\n")
    assert correction.decision.offset_is_enough
    assert 1e3 * correction.decision.offset_mm[0] == pytest.approx(-10.0)


def test_a_job_has_touches_or_readings(tmp_path: Path) -> None:
    job = shaft_with(tmp_path, SIX)
    job.write_text(job.read_text().replace('readings = "readings.csv"\n', ""))
    with pytest.raises(TrueloopError) as caught:
        read_job(job)
    assert "`touches` or `readings`" in str(caught.value)


def test_a_sheet_without_a_value_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as caught:
        read_job(shaft_with(tmp_path, f"{HEADER}seat-44,-85,\n"))
    assert caught.value.code is Code.MSR_NONE


@pytest.mark.parametrize(("row", "quantity"), [("fillet-2,,radius,2.02,", "radius"), ("cone,,angle,,11.32", "angle")])
def test_an_angle_or_an_arc_alone_is_refused_and_the_hint_leads_on(tmp_path: Path, row: str, quantity: str) -> None:
    """Neither states where the surface is: with one diameter besides the job is corrected, as the hint has it."""
    head = "# measured_at: 2026-11-20 09:40+01:00\nfeature,z_mm,quantity,value_mm,value_deg\n"
    with pytest.raises(TrueloopError) as caught:
        read_job(shaft_with(tmp_path, f"{head}{row}\n"))
    assert caught.value.code is Code.MSR_NONE and f"1 readings ({quantity})" in caught.value.message
    assert caught.value.hint == "read at least one diameter or length of a feature besides"
    done = corrected(tmp_path, f"{head}{row}\nseat-36,-60,diameter,36.020,\n")
    assert len(done.touches.point) == 1 and len(done.touches.seen) == 2


def test_limits_that_the_readings_state_are_judged(tmp_path: Path) -> None:
    """Of Ø 36.025 read where 35.98 to 36.02 are asked for, as of a characteristic of the job."""
    head = "characteristic,feature,quantity,z_mm,nominal,lower_limit,upper_limit,value_mm\n"
    rows = "d36,seat-36,diameter,-70,36,35.98,36.02,36.025\nd44,seat-44,diameter,-105,44,43.9,44.1,44.031\n"
    done = corrected(tmp_path, head + rows)
    names = {one.characteristic.name: one.characteristic.upper_limit for one in done.record.characteristics}
    assert names == {"d36": 36.02, "d44": 44.1}


def test_sizes_of_a_file_that_names_no_feature_are_judged_of_the_feature_that_they_correct(tmp_path: Path) -> None:
    """By their nominal sizes these are seat-44 and shoulder-1; of 99 mm the part has nothing."""
    sizes = (("Durchmesser 44", 44.0, 44.030), ("Durchmesser 99", 99.0, 99.001), ("Laenge 12", 12.0, 12.010))
    lines = ["K0100 3", "K1002 SHAFT"]
    for k, (name, nominal, _) in enumerate(sizes, 1):
        lines += [f"K2001/{k} {k}", f"K2002/{k} {name}", f"K2101/{k} {nominal}", f"K2142/{k} mm"]
        lines += [f"K2110/{k} {nominal - 0.02}", f"K2111/{k} {nominal + 0.02}"]
    lines.append("\x0f".join(f"{actual}\x140\x1420.11.2026/09:40:00" for *_, actual in sizes))
    job = shaft_with(tmp_path, SIX)
    (tmp_path / "q.dfq").write_text("\n".join(lines) + "\n")
    job.write_text(job.read_text().replace('"readings.csv"', '"q.dfq"'))
    done = compensate(read_job(job).inputs)
    judged = {one.characteristic.name: one for one in done.characteristics}
    assert {name: one.characteristic.feature for name, one in judged.items()} == {
        "Durchmesser 44": "seat-44",
        "Laenge 12": "shoulder-1",
    }
    before = judged["Durchmesser 44"].before
    assert before is not None and before.verdict == "out" and before.value == pytest.approx(44.030, abs=1e-9)
    assert [note for note in done.notes if "not judged" in note] == [
        "Durchmesser 99: of no feature of the part, not judged."
    ]


def test_an_axis_for_which_an_offset_is_enough_does_not_state_that_the_contour_stays(tmp_path: Path) -> None:
    """All diameters deviate by one amount, and the cone's angle, too: that angle needs the contour."""
    done = corrected(tmp_path, FIFTEEN_TOO_LARGE + "cone,angle,,,11.40,,,0.005\n")
    assert done.decision.x.enough and not done.decision.by_offset
    assert "such an offset is enough" in done.decision.x.words
    assert not any("stays as programmed" in words for words in done.decision.words)


FIFTEEN_TOO_LARGE = (
    "feature,quantity,z_mm,value_mm,value_deg,from,uncertainty_um,uncertainty_deg\n"
    "seat-44,diameter,-105,44.030,,,1,\nseat-36,diameter,-70,36.030,,,1,\nseat-36,diameter,-50,36.030,,,1,\n"
    "seat-30,diameter,-20,30.030,,,1,\njournal-24,diameter,-5,24.030,,,1,\n"
)
"""All stand off by 15 µm on the radius: an offset is enough for them."""


def of_line(program: bytes, comment: bytes) -> tuple[float, float]:
    """Where the line with a comment ends, (x as a radius, z), its words carried on from the lines before."""
    x = z = 0.0
    for line in program.splitlines():
        if word := re.search(rb"X(-?[\d.]+)", line):
            x = float(word[1]) / 2
        if word := re.search(rb"Z(-?[\d.]+)", line):
            z = float(word[1])
        if comment in line:
            return x, z
    raise AssertionError(comment)


def test_the_angle_of_a_cone_decides_with_the_diameters(tmp_path: Path) -> None:
    """Diameters alone: an offset. A cone 0.15° too steep: by hand from the words written, its angle is that much less.

    The part of it that the contour takes out is what the prior of a cone leaves of the reading, here over 0.13°.
    """
    assert corrected(tmp_path / "1", FIFTEEN_TOO_LARGE).decision.by_offset
    angle = "cone,angle,,,11.45993,,,0.01\n"
    correction = corrected(tmp_path / "2", FIFTEEN_TOO_LARGE + angle)
    assert not correction.decision.by_offset
    assert "+0.150° ± 0.020°, which no offset changes: the contour takes out +0.13" in correction.decision.words[2]
    (x1, z1), (x2, z2) = (of_line(correction.corrected_program, name) for name in (b"(SEAT 30)", b"(CONE)"))
    written = np.degrees(np.arctan2(x2 - x1, z1 - z2))
    assert written == pytest.approx(11.30993 - 0.137, abs=0.004)
    by_offset = corrected(tmp_path / "3", FIFTEEN_TOO_LARGE + angle, 'by = "offset"\n', "compensation")
    assert by_offset.decision.by_offset and "by the offset all the same" in by_offset.decision.words[2]


def test_the_radius_of_an_arc_and_a_length_between_two_faces_decide_too(tmp_path: Path) -> None:
    """Shoulders 40 µm too far apart are written 40 µm nearer; one that deviates within its ±U changes nothing."""
    length = "shoulder-2,length,,68.040,,shoulder-1,1,\n"
    correction = corrected(tmp_path / "1", FIFTEEN_TOO_LARGE + length)
    assert not correction.decision.by_offset
    faces = [of_line(correction.corrected_program, name)[1] for name in (b"(SHOULDER 1)", b"(SHOULDER 2)")]
    assert faces[0] - faces[1] == pytest.approx(68.0 - 0.040, abs=0.002)
    radius = corrected(tmp_path / "2", FIFTEEN_TOO_LARGE + "fillet-1,radius,,1.520,,,1,\n")
    assert not radius.decision.by_offset and "fillet-1 radius deviates by +20.0 µm" in radius.decision.words[2]
    small = corrected(tmp_path / "3", FIFTEEN_TOO_LARGE + length.replace("68.040", "68.001"))
    assert small.decision.by_offset and small.decision.unmoved is not None and small.decision.unmoved.enough
    assert CODEC.from_json(CODEC.to_json(radius), Correction) == radius


@pytest.mark.parametrize(("off_um", "enough"), [(0, True), (1, True), (12, False)])
def test_the_datum_of_lengths_is_no_reading_of_how_they_scatter(tmp_path: Path, off_um: int, enough: bool) -> None:
    """Two lengths from the end face to 2 µm, one off by d: p of χ² = (d/2)² with 2 degrees of freedom, exp(−d²/8). U of
    the offset along X, and readings too vague for any, are those of the diameters.
    """
    lengths = f"shoulder-1,length,,12,,end-face,2,\nshoulder-2,length,,{80 + off_um / 1000:.3f},,end-face,2,\n"
    without, done = (corrected(tmp_path / f"{k}", FIFTEEN_TOO_LARGE + rows) for k, rows in enumerate(("", lengths)))
    assert done.decision.z.p_value == pytest.approx(np.exp(-(off_um**2) / 8.0), rel=1e-6)
    assert done.decision.z.enough == done.decision.by_offset == enough and "at 2 touches" in done.decision.z.words
    assert done.decision.x.expanded_u_mm == pytest.approx(without.decision.x.expanded_u_mm, rel=1e-6)
    vague = (FIFTEEN_TOO_LARGE + lengths).replace(",1,\n", ",100,\n").replace(",2,\n", ",100,\n")
    with pytest.raises(TrueloopError) as refused:
        corrected(tmp_path / "vague", vague)
    assert refused.value.code is Code.CMP_SCATTER


def test_a_nominal_of_the_file_that_is_not_the_contours_is_named_with_both(tmp_path: Path) -> None:
    """`measure read` shows the file's deviation, the correction counts from the contour: 10 and 30 µm of one reading.

    A nominal that was rounded to 1 µm is the contour's.
    """
    header = "feature,z_mm,diameter_mm,nominal\n"
    job = shaft_with(tmp_path, f"{header}seat-30,-20,30.030,30.0005\njournal-24,-5,24.030,24.020\n")
    read = run("measure", "read", tmp_path / "readings.csv", "--job", job)
    corrected_by = run("compensate", job, "--no-store")
    for said in (read, corrected_by):
        assert "1 readings have another nominal value" in said
        assert "'journal-24 diameter z -5' 24.0200 and 24.0000 mm; a correction counts from the contour's" in said
    job = shaft_with(tmp_path / "same", f"{header}seat-30,-20,30.030,30\njournal-24,-5,24.030,24.001\n")
    assert "another nominal" not in run("measure", "read", tmp_path / "same" / "readings.csv", "--job", job)


TABLE = "Characteristic,Feature,Quantity,Actual,Deviation,Unit"
CALYPSO = ("planid", "partnb", "id", "idsymbol", "actual", "nominal", "uppertol", "lowertol", "deviation", "featureid")
CALYPSO_ROW = ("shaft", "1", "seat-30", "diameter", "30.030", "", "", "", "{}0.030", "seat-30")


@pytest.mark.parametrize("sign", ["", "-"])
@pytest.mark.parametrize(
    "text",
    [
        "feature,z_mm,diameter_mm,deviation\nseat-30,-20,30.030,{}0.030\n",
        TABLE + "\nd,seat-30,diameter,30.030,{}0.030,mm\n",
        "DIM d= LOCATION OF CYLINDER seat-30  UNITS=MM\nAX  MEAS  DEV\nD  30.030  {}0.030\nEND OF DIMENSION d\n",
        "\n".join(("\t".join(CALYPSO), "\t".join(CALYPSO_ROW), "END", "")),
    ],
    ids=["gauge", "table", "PC-DMIS", "CALYPSO"],
)
def test_a_deviation_is_compared_with_the_profiles_nominal_where_the_file_states_none(
    tmp_path: Path, text: str, sign: str
) -> None:
    mapping = tmp_path / "mapping.toml"
    columns = "".join(f'{name.lower()} = "{name}"\n' for name in TABLE.split(","))
    mapping.write_text(f'deviation = "actual - nominal"\n[columns]\n{columns}')
    stated = 'readings_mapping = "mapping.toml"\n' if "Quantity" in text else ""
    stated += 'readings_unit = "mm"\n' if "planid" in text else ""
    job = shaft_with(tmp_path, text.format(sign), stated)
    more = [*(["--mapping", mapping] if "mapping" in stated else []), *(["--unit", "mm"] if "unit" in stated else [])]
    read = run("measure", "read", tmp_path / "readings.csv", "--job", job, *more)
    for said in (read, run("compensate", job, "--no-store")):
        assert ("1 of 1 deviations are counted the other way" in said) == bool(sign)
        assert "another nominal value" not in said and "not matched" not in said


@pytest.mark.parametrize(
    ("half_um", "u_um", "outcome"), [(100, 1, "refused"), (100, 80, ""), (5, 1, "named"), (1, 1, ""), (5, 4, "")]
)
def test_readings_of_one_place_that_contradict_each_other(
    tmp_path: Path, half_um: int, u_um: int, outcome: str
) -> None:
    """Two readings d apart, by hand: improbable beyond 3.9 √2 u; 200 µm scatter by 200/√2/2 = 70.7 µm on the radius."""
    rows = "".join(f"seat-30,-20,{30.020 + sign * half_um / 1000:.3f},{u_um}\n" for sign in (1, -1))
    others = "".join(f"{row},1\n" for row in ALL_TOO_LARGE.splitlines() if "seat-30" not in row)
    job = shaft_with(tmp_path, "feature,z_mm,diameter_mm,uncertainty_um\n" + rows + others)
    if outcome == "refused":
        said = run("compensate", job, "--no-store", status=3)
        assert "CMP-SCATTER: 2 readings of one place, 'seat-30 diameter z -20', from 29.9200 to 30.1200 mm" in said
        assert "70.7 µm along the normal" in said
        text = job.read_text(encoding="utf-8")
        job.write_text(text.replace("[compensation]\n", "[compensation]\nmax_scatter_um = 80\n"), encoding="utf-8")
    said = run("compensate", job, "--no-store")
    assert ("are further apart than their standard uncertainty of 1.0 µm allows: their mean" in said) == bool(outcome)


def test_the_probability_of_the_next_part_is_that_of_one_cut_to_its_nominal_sizes(tmp_path: Path) -> None:
    """An h6 at its nominal value lies on its limit, out half of the time: `measure next` states what it counts from."""
    job = shaft_with(tmp_path, SIX)
    asked = '[[part.characteristic]]\nname = "D36"\nquantity = "diameter"\nfeature = "seat-36"\ntolerance = "h6"\n'
    job.write_text(job.read_text(encoding="utf-8").replace("[tool]\n", f"{asked}[tool]\n"), encoding="utf-8")
    said = run("measure", "next", job)
    assert "of the next part, corrected to its nominal sizes," in said and "(D36)" in said


@pytest.mark.parametrize("edge", ["X22.0\nX24.0 Z-1.0", "X24.0 ,C1.0", "X24.0 ,R1.0"])
def test_an_edge_that_is_broken_and_not_drawn_goes_with_what_is_beside_it(tmp_path: Path, edge: str) -> None:
    """The drawing has a sharp corner where the program has a chamfer or a radius, which ends on the seat."""
    job = shaft_with(tmp_path, SIX)
    sharp = job.read_text().replace('"journal-24", to = [24.0, -1.0]', '"journal-24", to = [24.0, 0.0]')
    job.write_text(sharp.replace('    { name = "chamfer", to = [22.0, 0.0] },\n', ""))
    inputs = read_job(job).inputs
    program = inputs.program
    source = re.sub(rb"X22.0 .END FACE.\nX24.0 Z-1.0 .CHAMFER.", edge.encode(), program.source)
    inputs = replace(
        inputs, program=read_program(source, program.dialect.name), options=replace(inputs.options, by="contour")
    )
    moves = read_program(compensate(inputs).corrected_program, "fanuc-lathe").run().end_mm[:, [0, 2]]
    (at,) = np.flatnonzero((np.abs(moves[:, 1] + 1.0) < 0.05) & (moves[:, 0] < 13.0))
    assert moves[at].tolist() == pytest.approx([12.0 - 0.0065, -1.0], abs=0.003)
    assert moves[at - 1].tolist() == pytest.approx([11.0 - 0.0065, 0.0], abs=0.0005)


@pytest.mark.parametrize(
    ("diameters", "named"),
    [
        ({"-105": 44.120}, "'seat-44 diameter z -105' 44.1200 mm, an error of +60.0 µm"),
        ({"-85": 43.920}, "'seat-44 diameter z -85' 43.9200 mm, an error of -40.0 µm"),
        ({"-95": 44.120}, "'seat-44 diameter z -95' 44.1200 mm, an error of +60.0 µm"),
        ({"-85": 44.080}, ""),  # a taper of 30 µm on the radius: of one line in twenty, which a note names
        ({"-85": 44.076}, ""),  # of 28 µm: 1.5 log-sd, √(26.9² + 2.3² + 5.7²) = 27.6 µm, are noted
        ({"-85": 44.074}, ""),  # of 27 µm: they are not
        ({"-105": 44.065}, ""),
        ({"-105": 43.960, "-85": 43.960}, ""),  # a bow of 30 µm
        ({"-100": 44.120, "-90": 44.120}, ""),  # no slip of one reading
    ],
)
def test_a_digit_typed_wrong_beside_another_reading_of_the_cylinder_is_named(
    tmp_path: Path, diameters: dict[str, float], named: str
) -> None:
    """0.1 mm on a diameter, 50 µm on the radius: the priors let form (6 µm, log-sd 1) and taper (40 µm/m, 0.7) of one
    line make 1.96 log-sd more, 42.6 µm and 3.2 µm over 20 mm; two readings to 1 µm may differ by 5.7 µm besides.
    """
    read = {"-105": 44.020, "-85": 44.020, **diameters}
    rows = [f"seat-44,{z},{size:.3f}\n" for z, size in read.items()]
    if any(z in diameters for z in ("-105", "-85")) and len(diameters) == 2:
        rows.append("seat-44,-95,44.020\n")
    job = shaft_with(tmp_path, HEADER + "".join(rows) + ALL_TOO_LARGE.partition("-85,44.020\n")[2])
    if not named:
        said = run("compensate", job, "--no-store")
        size = next(iter(diameters.values()))
        taper = f"'seat-44 diameter z -85' {size:.4f} mm stands {500.0 * (size - 44.020):.1f} µm along the normal from "
        assert (f"{taper}'seat-44 diameter z -105'" in said) == (list(diameters) == ["-85"] and size > 44.075)
        assert ("along the normal from" in said) == (size in {44.080, 44.076, 43.960})
        return
    said = run("compensate", job, "--no-store", status=3)
    assert "CMP-SCATTER" in said and f"{named}, stands apart from 'seat-44 diameter z" in said
    limit = np.hypot(np.hypot(6.0 * np.exp(1.96), 0.04 * np.exp(0.7 * 1.96) * 10.0), 4.0 * np.sqrt(2.0)) / np.sqrt(2.0)
    assert "scatter by 35.4 µm" in said and ("-95" not in diameters or f"at most {limit:.1f} µm" in said)
    assert "readings.csv:" in said and "digit typed wrong" in said
    text = job.read_text(encoding="utf-8")
    job.write_text(text.replace("[compensation]\n", "[compensation]\nmax_scatter_um = 36\n"), encoding="utf-8")
    assert "stands apart" not in run("compensate", job, "--no-store")


@pytest.mark.parametrize(
    ("column", "factor", "said"),
    [
        ("error_um", 1.0, ""),
        (
            "error_um",
            1e-3,
            "All 2 touches have errors below 0.3 µm: were they measured, and is the unit of their column",
        ),
        ("error_mm", 1.0, "micrometres in a column of millimetres?"),
    ],
)
def test_errors_in_a_column_of_another_unit_are_asked_about(
    column: str, factor: float, said: str, tmp_path: Path
) -> None:
    """Errors of 15 and 14 µm as stated, written as mm under µm (a correction of nothing), and as µm under mm."""
    job = shaft_with(tmp_path, SIX)
    rows = f"a,seat-44,22,-105,{15 * factor}\nb,seat-36,18,-60,{14 * factor}\n"
    (tmp_path / "t.csv").write_text(f"point,feature,nominal_x_mm,nominal_z_mm,{column}\n{rows}")
    job.write_text(job.read_text().replace('readings = "readings.csv"', 'touches = "t.csv"'))
    told = run("compensate", job, "--no-store", status=3 if column == "error_mm" else 0)
    assert said in told and ("All 2 touches" in told) == said.startswith("All")


def test_a_reading_typed_wrong_between_touches_is_named(tmp_path: Path) -> None:
    """Touches of +15 and +14 µm, and 44.129 read between them, an error of 64.5 µm: its line is named, no touch."""
    touches = "point,feature,nominal_x_mm,nominal_z_mm,error_um\na,seat-44,22,-105,15\nb,seat-44,22,-85,14\n"
    job = shaft_with(tmp_path, f"{HEADER}seat-44,-95,44.129\nseat-36,-60,36.030\n", 'touches = "t.csv"\n')
    (tmp_path / "t.csv").write_text(touches)
    said = run("compensate", job, "--no-store", status=3)
    assert "'seat-44 diameter z -95' 44.1290 mm, an error of +64.5 µm, stands apart from 'a'" in said


@pytest.mark.parametrize("begin", ["X18. Z0.", "X16. Z1."])
def test_edges_broken_before_the_first_cut_and_after_the_last_go_with_them(tmp_path: Path, begin: str) -> None:
    """A drawing without chamfers, 40 µm on both diameters: each coordinate of the pass becomes 40 µm smaller."""
    cuts = ("G42 G1 " + begin, "X20. Z-1.", "Z-30.", "X30.", "Z-60.", "X31. Z-60.5", "X36.")
    program = "\n".join(["O1", "G21 G40 G99", "T0303", "G97 S1500 M3", "F0.1", "G0 X40. Z2.", *cuts, "G40 X42.", "M30"])
    (tmp_path / "f.nc").write_text(program)
    (tmp_path / "r.csv").write_text(HEADER + "a,-35,30.040\na,-55,30.040\nc,-5,20.040\nc,-25,20.040\n")
    (tmp_path / "job.toml").write_text(
        '[part]\nname = "s"\nunit = "mm"\nx_is = "diameter"\nstart = [30, -60]\nfeature = ['
        '{name = "a", to = [30, -30]}, {name = "b", to = [20, -30]}, {name = "c", to = [20, 0]}]\n'
        "[tool]\nnose_radius_mm = 0.4\nnumber = 3\n"
        '[programs]\ndialect = "fanuc-lathe"\nfinish = "f.nc"\ncut_with = "given"\n[gauging]\nreadings = "r.csv"\n'
        '[compensation]\nby = "contour"\n[output]\nfolder = "out"\n'
    )
    written = compensate(read_job(tmp_path / "job.toml").inputs).corrected_program
    moves = read_program(written, "fanuc-lathe").run().end_mm[:, [0, 2]]
    given = read_program(program.encode(), "fanuc-lathe").run().end_mm[:, [0, 2]]
    moved = [0.0, *[-0.02] * 6, 0.0, 0.0]  # the rapid and what leads off the part stay
    np.testing.assert_allclose(moves[:, 0] - given[:, 0], moved, atol=1e-9)
    np.testing.assert_allclose(moves[:, 1], given[:, 1], atol=1e-9)


def test_what_the_contour_takes_out_beyond_an_offset_counts_what_an_angle_shows(tmp_path: Path) -> None:
    """One seat is read and the cone's angle: the offset is right for the seat, and the contour corrects the cone."""
    rows = "feature,quantity,z_mm,value_mm,value_deg\nseat-36,diameter,-60,36.020,\ncone,angle,,,11.40\n"
    done = corrected(tmp_path, f"# measured_at: 2026-11-20 09:40+01:00\n{rows}")
    assert not done.decision.by_offset and done.by_tool is not None
    assert done.by_tool.beyond_on == "cone" and "cone" in done.by_tool.beyond_words
    (cone,) = [one for one in done.by_tool.features if one.feature == "cone"]
    assert cone.touched and "not measured" not in cone.words
