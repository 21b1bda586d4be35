"""Characteristics of a job file: units, defaults from the profile, general tolerances, what a file adds."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.cli import run
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.turned.characteristics import joined
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Inputs

EXAMPLES = Path(__file__).parents[3] / "examples"


def read(tmp_path: Path, name: str, text: str, part: str = "") -> Inputs:
    shutil.copytree(EXAMPLES / name, tmp_path, dirs_exist_ok=True)
    job = tmp_path / "job.toml"
    job.write_text(job.read_text().replace("[part]\n", f"[part]\n{part}\n", 1) + text)
    return read_job(job).inputs


def tables(*keys: str) -> str:
    return "".join(f"\n[[part.characteristic]]\n{one}\n" for one in keys)


def test_numbers_are_in_the_unit_of_the_part_and_diameters_are_diameters(tmp_path: Path) -> None:
    """The profile is in inches and radii; the cylinder's radius is 0.86 inch."""
    inputs = read(
        tmp_path,
        "facetst",
        tables(
            'name = "D1"\nquantity = "diameter"\nfeature = "small-cylinder"\ntolerance = "+0.001/-0.002"',
            'name = "D2"\nquantity = "diameter"\nfeature = "large-cylinder"\nnominal = 5.621\nlower_limit = 5.61\n'
            "upper_limit = 5.622",
            'name = "L1"\nquantity = "length"\nfeature = "step-face"\ntolerance = "h11"',
        ),
    )
    d1, d2, l1 = inputs.characteristics

    assert (d1.nominal, d1.lower_limit, d1.upper_limit) == pytest.approx((43.688, 43.688 - 0.0508, 43.688 + 0.0254))
    assert (d2.nominal, d2.lower_limit, d2.upper_limit) == pytest.approx((142.7734, 142.494, 142.7988))
    assert (l1.nominal, l1.lower_limit, l1.upper_limit) == pytest.approx((50.8, 50.8 - 0.190, 50.8))


def test_a_general_tolerance_holds_for_every_feature_without_its_own(tmp_path: Path) -> None:
    """MODBAS2: diameters 145.288 to 74.168, faces at z −155.829 and −44.704, a cone, and the dome's radius 37.084."""
    own = tables('name = "D1"\nquantity = "diameter"\nfeature = "main-cylinder"\ntolerance = "h9"')
    inputs = read(tmp_path, "modbas2", own, 'general_tolerance = "ISO 2768-mK"')
    found = {one.name: (one.nominal, one.upper_limit) for one in inputs.characteristics}

    assert next(iter(found)) == "D1"
    half = {name: (upper or 0.0) - nominal for name, (nominal, upper) in found.items() if name != "D1"}
    assert half == pytest.approx(
        {
            "collar diameter": 0.5,
            "step-face length": 0.5,
            "cone angle": 0.5,  # its side is 47.2 mm long
            "main-face length": 0.3,
            "small-cylinder diameter": 0.3,
            "dome radius": 0.3,
        }
    )


def test_a_general_tolerance_that_is_none_is_refused_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as refused:
        read(tmp_path, "modbas2", "", 'general_tolerance = "ISO 22081"')
    assert refused.value.code is Code.TOL_TEXT
    assert refused.value.place.line == 4


@pytest.mark.parametrize(
    ("keys", "code"),
    [
        ('quantity = "diameter"\nfeature = "small-cylinder"\ntolerance = "h66"', Code.TOL_FIT),
        ('quantity = "diameter"\nfeature = "small-cylinder"\ntolerance = "roughly"', Code.TOL_TEXT),
        ('quantity = "diameter"\nfeature = "small-cylinder"\ntolerance = "f7"', Code.TOL_ZONE),
        ('quantity = "diameter"\nfeature = "small-cylinder"\ntolerance = "±0"', Code.TOL_ZONE),
        ('quantity = "diameter"\nfeature = "small-cylinder"\nlower_limit = 1.8\nupper_limit = 1.7', Code.TOL_ZONE),
        ('quantity = "diameter"\nfeature = "small-cylinder"\nnominal = 0.86\ntolerance = "±0.01"', Code.TOL_NOMINAL),
        ('quantity = "length"\nfeature = "end-face"\ntolerance = "±0.01"', Code.TOL_PLACE),
        ('quantity = "length"\nfeature = "step-face"\nother = "shoulder"\ntolerance = "±0.01"', Code.TOL_FEATURE),
        ('quantity = "diameter"\nfeature = "bore"\ntolerance = "±0.01"', Code.TOL_FEATURE),
        ('quantity = "girth"\nfeature = "bore"\ntolerance = "±0.01"', Code.JOB_KEY),
        ('quantity = "diameter"\nfeature = "small-cylinder"', Code.JOB_KEY),
        ('quantity = "diameter"\nfeature = "small-cylinder"\ntolerance = "h6"\nupper_limit = 1.8', Code.JOB_KEY),
        ('quantity = "diameter"\nfeature = "small-cylinder"\nupper_limit = nan', Code.JOB_KEY),
        ('quantity = "diameter"\nfeature = "small-cylinder"\nother = "end-face"\ntolerance = "h6"', Code.JOB_KEY),
        ('quantity = "length"\nfeature = "step-face"\nat_z_mm = -1.0\ntolerance = "h6"', Code.JOB_KEY),
    ],
)
def test_a_wrong_characteristic_is_refused_with_its_line(tmp_path: Path, keys: str, code: Code) -> None:
    with pytest.raises(TrueloopError) as refused:
        read(tmp_path, "facetst", tables(f'name = "X"\n{keys}'))
    assert refused.value.code is code
    assert refused.value.place.file == str(tmp_path / "job.toml")
    assert refused.value.place.line is not None
    assert refused.value.place.line > 30


def test_a_fit_away_from_the_nominal_is_taken_where_the_profile_is_in_the_zone(tmp_path: Path) -> None:
    """43.7 f7 is 43.650 to 43.675 mm: the profile, at 43.688 mm, is not in it; 43.71 f7 holds 43.688."""
    keys = 'name = "D1"\nquantity = "diameter"\nfeature = "small-cylinder"\nnominal = {nominal}\ntolerance = "f7"'
    with pytest.raises(TrueloopError) as refused:
        read(tmp_path / "one", "facetst", tables(keys.format(nominal=43.7 / 25.4)))
    assert refused.value.code is Code.TOL_ZONE
    (one,) = read(tmp_path / "two", "facetst", tables(keys.format(nominal=43.72 / 25.4))).characteristics
    assert (one.lower_limit, one.upper_limit) == pytest.approx((43.67, 43.695))


def test_one_sided_limits_stay_one_sided(tmp_path: Path) -> None:
    (one,) = read(
        tmp_path,
        "facetst",
        tables('name = "D1"\nquantity = "diameter"\nfeature = "small-cylinder"\nupper_limit = 1.73'),
    ).characteristics
    assert one.lower_limit is None
    assert one.upper_limit == pytest.approx(43.942)


def test_a_file_adds_what_the_job_does_not_have(tmp_path: Path) -> None:
    inputs = read(
        tmp_path,
        "facetst",
        tables('name = "D1"\nquantity = "diameter"\nfeature = "small-cylinder"\ntolerance = "±0.001"'),
    )
    (ours,) = inputs.characteristics
    same_place = replace(ours, name="DIA1", upper_limit=43.7)
    new = Characteristic("L7", Quantity.LENGTH, "PLN3", 50.8, 50.7, 50.9, other="end-face")
    lost = Characteristic("D9", Quantity.DIAMETER, "CYL9", 30.0, 29.9, 30.1)
    runout = Characteristic("R1", Quantity.RUNOUT, "small-cylinder", 0.0, 0.0, 0.01)
    of_radius = Characteristic("D3", Quantity.DIAMETER, "large-cylinder", 71.374, 71.3, 71.4)
    found, notes = joined((ours,), (same_place, new, lost, runout, of_radius), inputs.profile, {"PLN3": "step-face"})

    assert found == (ours, replace(new, feature="step-face"))
    assert len(notes) == 4
    for note, words in zip(notes, ("D1: the limits", "'D9' is of feature", "a runout", "half of"), strict=True):
        assert words in note


BARREL = """characteristic,feature,quantity,unit,nominal,lower_limit,upper_limit,actual,z mm
d0,shaft,diameter,mm,40,39.97,40.03,40.0250,-95.0
d1,shaft,diameter,mm,40,39.97,40.03,40.0450,-72.0
d2,shaft,diameter,mm,40,39.97,40.03,40.0507,-50.0
d3,shaft,diameter,mm,40,39.97,40.03,40.0440,-27.0
d4,shaft,diameter,mm,40,39.97,40.03,40.0251,-5.0
"""


def test_several_diameters_of_a_file_are_judged_where_each_was_read(tmp_path: Path) -> None:
    """Else the ends of a barrel would be as large as its middle; a diameter of the job holds along the whole shaft."""
    (tmp_path / "finish.nc").write_text(
        "G21 G8 G40 T1 M6\nG0 X-0.2 Z0.8\nG1 X20.8 Z0.8 F100\nX20.8 Z-99.2\nX30.8\nM2\n"
    )
    (tmp_path / "readings.csv").write_text(BARREL)
    job = (
        '[part]\nname = "barrel"\nstart = [30.0, -100.0]\nfeature = [{ name = "shoulder", to = [20.0, -100.0] }, '
        '{ name = "shaft", to = [20.0, 0.0] }, { name = "face", to = [0.0, 0.0] }]\n{more}'
        "[tool]\nnose_radius_mm = 0.8\n"
        '[programs]\ndialect = "linuxcnc"\nfinish = "finish.nc"\n[gauging]\nreadings = "readings.csv"\n'
    )
    (tmp_path / "job.toml").write_text(job.replace("{more}", ""))
    run("compensate", tmp_path / "job.toml", "-o", tmp_path / "out", "--no-store")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    found = {one["name"]: one for one in report["characteristics"]}
    actual = {line.split(",")[0]: float(line.split(",")[7]) for line in BARREL.splitlines()[1:]}
    places = {line.split(",")[0]: float(line.split(",")[8]) for line in BARREL.splitlines()[1:]}
    assert {name: one["at_z_mm"] for name, one in found.items()} == places
    assert {name: one["before"]["value"] for name, one in found.items()} == pytest.approx(actual, abs=0.002)
    assert {name for name, one in found.items() if one["before"]["value"] > 40.03} == {"d1", "d2", "d3"}
    seat = '[[part.characteristic]]\nname = "seat"\nquantity = "diameter"\nfeature = "shaft"\ntolerance = "±0.05"\n'
    (tmp_path / "job.toml").write_text(job.replace("{more}", seat))
    run("compensate", tmp_path / "job.toml", "-o", tmp_path / "whole", "--no-store")
    report = json.loads((tmp_path / "whole" / "report.json").read_text())
    assert [one["name"] for one in report["characteristics"]] == ["seat"]


def test_a_length_from_the_part_s_zero_is_that_from_the_face_there(tmp_path: Path) -> None:
    inputs = read(tmp_path, "facetst", "")
    profile = inputs.profile
    faces = [(one.name, one.start_mm[1]) for one in profile.features if one.start_mm[1] == one.end_mm[1]]
    (zero,) = [name for name, z in faces if z == 0.0]
    step = next(name for name, z in faces if z != 0.0)
    ours = Characteristic("L1", Quantity.LENGTH, step, 50.8, 50.7, 50.9)
    found, notes = joined((ours,), (replace(ours, name="Item 4", other=zero),), profile, {})
    assert found == (ours,) and not notes
