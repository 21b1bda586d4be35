"""Inspections written as DMIS and read again."""

from dataclasses import fields, replace
from datetime import datetime
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.dmis import read_text
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.dmis.results import dmis_results
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts

LENGTHS = st.integers(-(10**9), 10**9).map(lambda nanometres: nanometres / 1e6)
SIZES = st.integers(10**5, 10**8).map(lambda nanometres: nanometres / 1e6)
VECTORS = st.tuples(LENGTHS, LENGTHS, LENGTHS)
NAMES = st.text("abcXYZ019 -_.äØ", min_size=1, max_size=12).map(str.strip).filter(bool)
NORMALS = st.sampled_from([(1.0, 0.0, 0.0), (0.0, 0.6, -0.8), (0.0, 0.0, 1.0)])
POINTS = st.builds(CmmPoint, VECTORS, VECTORS, NORMALS, NAMES)


@st.composite
def _reading(draw: st.DrawFn, name: str) -> Reading:
    quantity = draw(st.sampled_from(sorted(Quantity)))
    sized = quantity in (Quantity.DIAMETER, Quantity.RADIUS)
    coordinate = quantity is Quantity.POSITION and draw(st.booleans())
    nominal = draw(SIZES) if sized or quantity is Quantity.LENGTH else draw(LENGTHS)
    place: tuple[float, ...] = draw(VECTORS) if sized or coordinate else ()
    axis = draw(st.sampled_from("xyz")) if coordinate else ""
    if coordinate:
        place = tuple(nominal if letter == axis else value for letter, value in zip("xyz", place, strict=True))
    limit = st.none() | st.integers(0, 10**5).map(lambda nanometres: nanometres / 1e6)
    below, above = draw(limit), draw(limit)
    other = draw(NAMES.map(lambda text: "o" + text)) if quantity is Quantity.LENGTH else ""
    return Reading(
        characteristic=name,
        quantity=quantity,
        actual=nominal + draw(st.integers(-(10**5), 10**5)) / 1e6,
        nominal=nominal,
        lower_limit=None if below is None else nominal - below,
        upper_limit=None if above is None else nominal + above,
        feature="F " + name,
        other=other,
        axis=axis,  # type: ignore[arg-type]
        place_mm=place,
        side=draw(st.sampled_from(["", "inner", "outer"])) if sized or coordinate else "",
    )


@st.composite
def _inspection(draw: st.DrawFn) -> Inspection:
    names = draw(st.lists(NAMES, min_size=1, max_size=5, unique_by=lambda text: "".join(text.split()).upper()))
    readings = [draw(_reading(name)) for name in names]
    points = draw(st.lists(POINTS, max_size=3))
    values = (*readings, *points)
    serial, device = draw(st.sampled_from(["", "A-1"])), draw(st.sampled_from(["", "CMM 'the third'"]))
    part = Part(PartType(draw(NAMES), draw(st.sampled_from(["", "C"]))), serial)
    measured = "readings and CMM points" if points else "readings"
    at = draw(
        st.none() | st.datetimes(datetime(1970, 1, 1), datetime(2100, 1, 1)).map(lambda t: t.replace(microsecond=0))
    )
    return Inspection(part, measured, "", len(values), values, device=device, measured_at=at)  # type: ignore[arg-type]


def _comparable(inspection: Inspection) -> list[object]:
    """All but the lines, numbers to a nanometre, values of one kind after the other: results follow features."""
    values = [
        (type(value).__name__, *(_rounded(getattr(value, one.name)) for one in fields(value) if one.name != "line"))
        for value in inspection.values
    ]
    heading = replace(inspection, values=(), sha256="")
    return [heading, *sorted(values, key=repr)]


def _rounded(item: object) -> object:
    if isinstance(item, tuple):
        return tuple(_rounded(one) for one in item)
    return round(item, 6) + 0.0 if isinstance(item, float) else item


@given(st.lists(_inspection(), min_size=1, max_size=3))
def test_what_is_written_is_read_again(inspections: list[Inspection]) -> None:
    text = dmis_results(inspections, "results.dmo")
    file = read_text(text, name="results.dmo")
    assert [_comparable(one) for one in file.inspections] == [_comparable(one) for one in inspections]
    assert not [remark for remark in file.remarks if "exactly nominal" not in remark.text]
    again = dmis_results(file.inspections, "results.dmo")
    second = read_text(again, name="results.dmo")
    assert [_comparable(one) for one in second.inspections] == [_comparable(one) for one in file.inspections]


def test_a_diameter_is_written_as_one_with_relative_limits() -> None:
    reading = Reading("D", Quantity.DIAMETER, 30.004, 30.0, 29.98, 30.01, "J", place_mm=(-20.0,), side="outer")
    inspection = Inspection(Part(PartType("shaft")), "readings", "", 1, (reading,))
    assert dmis_results([inspection], "shaft.dmo").splitlines()[3:] == [
        "OUTPUT/F(J),T(D)",
        "F(J)=FEAT/CIRCLE,OUTER,CART,0,0,-20,,,,30",
        "T(D)=TOL/DIAM,-0.02,0.01",
        "OUTPUT/FA(J),TA(D)",
        "FA(J)=FEAT/CIRCLE,OUTER,CART,,,,,,,30.004",
        "TA(D)=TOL/DIAM,0.004,INTOL",
        "ENDFIL",
    ]


@pytest.mark.parametrize(("actual", "verdict"), [(30.0101, "OUTOL"), (29.9799, "OUTOL"), (29.98, "INTOL")])
def test_a_verdict_is_that_of_the_limits(actual: float, verdict: str) -> None:
    reading = Reading("D", Quantity.DIAMETER, actual, 30.0, 29.98, 30.01, "J")
    inspection = Inspection(Part(PartType("shaft")), "readings", "", 1, (reading,))
    assert f",{verdict}\n" in dmis_results([inspection], "shaft.dmo")


@pytest.mark.parametrize("value", [Touch("1", (1.0, 2.0), error_mm=0.01), CmmPoint((1.0, 2.0, 3.0))])
def test_centres_of_a_ball_and_touches_are_not_written(value: Touch | CmmPoint) -> None:
    part = Part(PartType("shaft"))
    with pytest.raises(TrueloopError, match="1 values") as refused:
        dmis_results([Inspection(part, "touches", "", 1, (value,), ball_radius_mm=1.0)], "shaft.dmo")
    assert refused.value.code is Code.MSR_FORMAT


@pytest.mark.corpus
@pytest.mark.parametrize("name", ["modbas2-semifinish.dmo", "shaft-two-runs.dmo"])
def test_files_in_the_form_of_real_ones_come_back(name: str, corpus: Path) -> None:
    file = read_measured_file(corpus / "data" / "made" / "dmis" / name, StatedFacts())
    again = read_text(dmis_results(file.inspections, name), name=name)
    assert [_comparable(one) for one in again.inspections] == [_comparable(one) for one in file.inspections]
