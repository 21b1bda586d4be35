"""A job corrected by what a measuring machine wrote: its points are touches, its characteristics are judged."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.dmis.results import dmis_results
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.process_intermittent import compensate

EXAMPLES = Path(__file__).parents[2] / "examples"
JOB = EXAMPLES / "linuxcnc" / "job.toml"
SEAT = Reading(
    *("seat", Quantity.DIAMETER, 74.18, 74.168, 74.1, 74.2), feature="small-cylinder", place_mm=(0.0, 0.0, -40.0)
)
BY_POINTS = 'readings = "part.dmo"\nz_reference = "11"'


def inputs(folder: Path, gauging: str) -> Inputs:
    """The LinuxCNC example with another table [gauging]."""
    text = JOB.read_text(encoding="utf-8")
    head = text[: text.index("[gauging]")].replace('"finish.ngc"', f'"{EXAMPLES}/linuxcnc/finish.ngc"')
    (folder / "job.toml").write_text(f"{head}[gauging]\n{gauging}\n", encoding="utf-8")
    return read_job(folder / "job.toml").inputs


def write_report(folder: Path, *readings: Reading, left_on_mm: float = 0.0) -> None:
    """The example's touches as points of a measuring machine, in DMIS."""
    known, values = read_job(JOB).inputs, list[CmmPoint | Reading](readings)
    for touch in known.inspections[0].touches:
        feature = known.profile.features[known.profile.names.index(touch.feature or "")]
        nx, nz = feature.outward_normal(float(feature.locate(touch.nominal_mm)[0])).tolist()
        (x, z), far = touch.nominal_mm, (touch.error_mm or 0.0) + left_on_mm
        values.append(CmmPoint((x + far * nx, 0.0, z + far * nz), (x, 0.0, z), (nx, 0.0, nz), touch.point))
    inspection = Inspection(Part(PartType("MODBAS2")), "readings and CMM points", "", len(values), tuple(values))
    (folder / "part.dmo").write_text(dmis_results([inspection], "part"), encoding="utf-8")


@pytest.mark.parametrize(("left_on_mm", "stated"), [(0.0, ""), (0.2, "\nmeasured_allowance_mm = 0.2")])
def test_points_correct_as_the_touches_that_they_are(tmp_path: Path, left_on_mm: float, stated: str) -> None:
    write_report(tmp_path, left_on_mm=left_on_mm)
    by_touches, by_points = read_job(JOB).inputs, inputs(tmp_path, BY_POINTS + stated)
    assert by_points.touches.point == by_touches.touches.point
    np.testing.assert_allclose(by_points.touches.error_mm, by_touches.touches.error_mm, atol=2e-6)
    found, expected = (compensate(one).prediction.after_mm for one in (by_points, by_touches))
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_what_a_file_asks_for_is_judged_beside_what_the_job_asks_for(tmp_path: Path) -> None:
    """By hand: Ø 74.180 between 74.100 and 74.200 is in; corrected it is 74.168 within some micrometres."""
    write_report(tmp_path, SEAT)
    correction = compensate(inputs(tmp_path, BY_POINTS))
    (judged,) = correction.characteristics
    assert judged.characteristic.feature == "small-cylinder"
    assert judged.characteristic.nominal == pytest.approx(74.168)
    assert (judged.characteristic.lower_limit, judged.characteristic.upper_limit) == pytest.approx((74.1, 74.2))
    assert judged.after.verdict == "in" and abs(judged.after.value - 74.168) < 0.01


def test_names_of_a_mapping_lead_to_features(tmp_path: Path) -> None:
    write_report(tmp_path)
    text = (tmp_path / "part.dmo").read_text(encoding="utf-8")
    (tmp_path / "names.toml").write_text('[features]\n"13" = "nose"\n', encoding="utf-8")
    with pytest.raises(TrueloopError) as refused:
        inputs(tmp_path, f'{BY_POINTS}\nreadings_mapping = "names.toml"')
    assert refused.value.code is Code.MSR_MAPPING and "nose" in refused.value.message
    (tmp_path / "names.toml").write_text('[features]\n"13" = "dome"\n', encoding="utf-8")
    named = inputs(tmp_path, f'{BY_POINTS}\nreadings_mapping = "names.toml"')
    assert text and named.touches.point == read_job(JOB).inputs.touches.point


def test_points_and_touches_of_a_probe_join_in_their_order_along_the_part(tmp_path: Path) -> None:
    """Half of the touches by the probe, the other half by the machine: together as all of them."""
    write_report(tmp_path)
    rows = (EXAMPLES / "modbas2" / "touches.csv").read_text(encoding="utf-8").splitlines()
    comments = [row for row in rows if row.startswith("#")]
    header, *touches = [row for row in rows if not row.startswith("#")]
    (tmp_path / "touches.csv").write_text("\n".join([*comments, header, *touches[::2]]) + "\n", encoding="utf-8")
    lines = (tmp_path / "part.dmo").read_text(encoding="utf-8").splitlines()
    probed = {row.partition(",")[0] for row in touches[::2]}
    kept = [line for line in lines if not any(f"({point})" in line for point in probed)]
    (tmp_path / "part.dmo").write_text("\n".join(kept) + "\n", encoding="utf-8")
    both = inputs(tmp_path, f'{BY_POINTS}\ntouches = "touches.csv"')
    assert both.touches.point == read_job(JOB).inputs.touches.point
    np.testing.assert_allclose(both.touches.error_mm, read_job(JOB).inputs.touches.error_mm, atol=2e-6)


@pytest.mark.parametrize("ending", [".dmo", ".qif"])
def test_a_time_without_a_zone_is_the_clock_on_the_wall(tmp_path: Path, ending: str) -> None:
    """DMIS knows no zones: a job of its values is corrected as one of the CSV that states its zone."""
    shutil.copytree(EXAMPLES / "shaft", tmp_path / "shaft")
    job = tmp_path / "shaft" / "job.toml"
    wanted = compensate(read_job(job).inputs).wear
    invoke("measure", "convert", job.with_name("readings.csv"), "-o", job.with_name(f"shaft{ending}"), status=0)
    job.write_text(job.read_text(encoding="utf-8").replace("readings.csv", f"shaft{ending}"), encoding="utf-8")
    inputs = read_job(job).inputs
    assert inputs.measured_at is not None and inputs.measured_at.tzinfo is not None
    assert compensate(inputs).wear == wanted
