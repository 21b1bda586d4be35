"""Tolerances on the faces of a STEP solid become characteristics of the profile's features."""

import math
import random
from pathlib import Path

import numpy as np
import pytest

from tests.support.pmi import Asked, toleranced
from tests.support.profiles import polyline
from tests.support.solids import drill, revolved, without
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.formats.cad.step_profile import read_step_profile
from trueloop.formats.cad.step_tolerances import Ref, Typed, fitting, read_records, stated_in
from trueloop.geometry.validate import checked_profile

SECTION = [(8.0, -60.0), (30.0, -60.0), (30.0, -20.0), (25.0, -20.0), (25.0, -2.0), (23.0, 0.0), (8.0, 0.0)]
"""Faces in the file's order: bore 16, chuck face, cylinder 60, shoulder, cylinder 50, chamfer, free end."""
HOLE, CHUCK, BIG, SHOULDER, SMALL, CHAMFER, END = range(7)


def of(found: tuple[Characteristic, ...]) -> dict[str, tuple[object, ...]]:
    return {
        one.name: (one.quantity, one.feature, one.other, one.nominal, one.lower_limit, one.upper_limit, one.tolerance)
        for one in found
    }


def test_dimensions_become_characteristics_of_the_features_they_are_on(tmp_path: Path) -> None:
    """Deviations keep their sign, also where both are positive; a cone's own angle is twice that to the axis."""
    asked = [
        Asked("diameter", [BIG], 60.0, (0.005, 0.021)),
        Asked("diameter", [SMALL], 50.0, fit=("h", "6")),
        Asked("linear distance", [SHOULDER, END], 20.0, limits=(19.9, 20.05)),
        Asked("angle", [CHAMFER], 90.0, (-1.0, 1.0)),
        Asked("STRAIGHTNESS", [BIG], 0.004),
        Asked("CYLINDRICITY", [BIG], 0.006),
        Asked("diameter", [HOLE], 16.0, fit=("H", "7")),
    ]
    path = toleranced(revolved(SECTION), asked, tmp_path / "part.step")
    read = read_step_profile(path)
    near = pytest.approx
    assert of(read.characteristics) == {
        "cylinder-1 diameter": (Quantity.DIAMETER, "cylinder-1", "", 60.0, near(60.005), near(60.021), ""),
        "cylinder-2 diameter": (Quantity.DIAMETER, "cylinder-2", "", 50.0, None, None, "h6"),
        "face-2 to face-3": (Quantity.LENGTH, "face-2", "face-3", 20.0, near(19.9), near(20.05), ""),
        "cone-1 angle": (Quantity.ANGLE, "cone-1", "", near(45.0), near(44.5), near(45.5), ""),
        "cylinder-1 form": (Quantity.FORM, "cylinder-1", "", 0.0, None, near(0.004), ""),
    }
    assert "Tolerance left out: cylindricity … to 0.0060 of cylinder-1, which a profile does not show." in read.notes
    assert "Tolerance left out: diameter 16.0000 H7, not of this side's turned features." in read.notes
    bore = read_step_profile(path, side="inside")
    assert of(bore.characteristics) == {
        "cylinder-1 diameter": (Quantity.DIAMETER, "cylinder-1", "", 16.0, None, None, "H7")
    }


def test_lengths_of_a_file_in_inches_are_millimetres(tmp_path: Path) -> None:
    path = toleranced(
        revolved([(x * 25.4, z * 25.4) for x, z in SECTION]),
        [Asked("diameter", [BIG], 60.0, (-0.001, 0.002))],
        tmp_path / "part.step",
        "INCH",
    )
    (one,) = read_step_profile(path).characteristics
    np.testing.assert_allclose(
        [one.nominal, one.lower_limit or 0.0, one.upper_limit or 0.0],
        np.array([60.0, 59.999, 60.002]) * 25.4,
        atol=1e-9,
    )


def test_a_tolerance_of_a_cross_hole_is_told_and_left_out(tmp_path: Path) -> None:
    solid = without(revolved(SECTION), drill((0, 0, -40), (1, 0, 0), 3.0, 60.0))
    text = toleranced(solid, [], tmp_path / "bare.step").read_text()
    faces = [line for line in text.splitlines() if " = ADVANCED_FACE" in line]
    asked = [Asked("diameter", [k], 6.0, (0.0, 0.01)) for k in range(len(faces))]
    read = read_step_profile(toleranced(solid, asked, tmp_path / "part.step"))
    assert len(read.characteristics) == 2  # on the two cylinders of the outside
    assert sum("not of this side's turned features" in note for note in read.notes) == 2  # the bore and the cross hole


def test_what_the_job_would_refuse_is_not_proposed() -> None:
    """Limits that exclude the solid's own size: the correction aims at the profile."""
    profile = checked_profile(polyline([(30.0, -20.0), (30.0, 0.0), (10.0, 0.0)]))
    good = Characteristic("d", Quantity.DIAMETER, "f0", 60.0, 59.99, 60.01)
    away = Characteristic("a", Quantity.DIAMETER, "f0", 60.0, 60.01, 60.02)
    fit = Characteristic("f", Quantity.DIAMETER, "f0", 60.0, tolerance="h6")
    nonsense = Characteristic("n", Quantity.DIAMETER, "f0", 60.0, tolerance="h99")
    proposed = fitting([good, away, fit, nonsense], profile)
    assert proposed.characteristics == (good, fit)
    assert len(proposed.notes) == 2 and "exclude the 60.0000 mm" in proposed.notes[0]


def test_records_are_read_as_they_are_spelt() -> None:
    text = """ISO-10303-21;HEADER;FILE_NAME('DATA;');ENDSEC;
    DATA;
    #1=A('it''s; (x)',#2,(1.,-2.5E-3,$,*),.T.); /* a remark; #9=B(); */
    #2 = ( LENGTH_UNIT() MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#3)
    );
    ENDSEC;END-ISO-10303-21;"""
    records = read_records(text)
    assert records.numbers == (1, 2)
    assert records.of[1].types == {"A": ["it's; (x)", Ref(2), [1.0, -0.0025, None, None], "T"]}
    assert records.of[2].types["MEASURE_WITH_UNIT"] == [Typed("LENGTH_MEASURE", [25.4]), Ref(3)]
    assert math.isclose(sum(records.of[1].refs()), 2)


@pytest.mark.parametrize("damage", ["#9", "DIMENSIONAL_SIZE(", "'", "(((", "PLUS_MINUS_TOLERANCE(#1,#1);"])
def test_damaged_tolerances_end_in_no_characteristic(tmp_path: Path, damage: str) -> None:
    path = toleranced(revolved(SECTION), [Asked("diameter", [BIG], 60.0, (0.0, 0.02))], tmp_path / "part.step")
    text = path.read_text()
    damaged = read_records(text.replace("DIMENSIONAL_SIZE(#", f"DIMENSIONAL_SIZE({damage}#", 1))
    limited = [one for one in stated_in(damaged) if one.faces and all(one.faces)]
    assert all(one.upper is None or one.upper == pytest.approx(60.02) for one in limited)


def test_a_unit_that_is_stated_in_itself_has_no_size() -> None:
    text = """DATA;#1=DIMENSIONAL_SIZE(#2,'diameter');#3=DIMENSIONAL_CHARACTERISTIC_REPRESENTATION(#1,#4);
    #4=SHAPE_DIMENSION_REPRESENTATION('',(#5),#9);#5=MEASURE_WITH_UNIT(LENGTH_MEASURE(1.),#6);
    #6=(CONVERSION_BASED_UNIT('X',#5));ENDSEC;"""
    (one,) = stated_in(read_records(text))
    assert one.nominal is None


@pytest.mark.parametrize("seed", range(4))
def test_no_damage_of_the_records_raises(tmp_path: Path, seed: int) -> None:
    """Pieces cut out and changed anywhere: what is left is read, or not, but never ends in an error of the program."""
    asked = [
        Asked("diameter", [BIG], 60.0, (0.0, 0.02)),
        Asked("diameter", [SMALL], 50.0, fit=("h", "6")),
        Asked("linear distance", [SHOULDER, END], 20.0, limits=(19.9, 20.05)),
        Asked("angle", [CHAMFER], 90.0, (-1.0, 1.0)),
        Asked("CYLINDRICITY", [BIG], 0.006),
    ]
    text = toleranced(revolved(SECTION), asked, tmp_path / "part.step").read_text()
    start, rng = text.index("GEOMETRIC_ITEM_SPECIFIC_USAGE") - 60, random.Random(seed)
    for _ in range(300):
        at, gone = rng.randrange(start, len(text)), rng.choice([1, 1, 2, 7, 40])
        list(stated_in(read_records(text[:at] + rng.choice(["", "", "$", "(", ")", "#7", "'"]) + text[at + gone :])))
