"""A table says the same whatever its separator, decimal mark, order of columns, unit and rows above it are."""

import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.domain.inspection import Reading
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts

HEADINGS = {
    "name": ["Merkmal", "Characteristic", "name", "Bezeichnung"],
    "nominal": ["Nominal", "Sollwert", "Nennmaß", "NOM"],
    "actual": ["Actual", "Istwert", "Ist-Maß", "MEAS", "Measured value"],
    "deviation": ["Deviation", "Abw.", "DEV"],
    "upper": ["+Tol", "OT", "Upper tolerance", "oberes Abmaß"],
    "lower": ["-Tol", "UT", "Lower tol.", "unteres Abmaß"],
    "serial": ["Serial No.", "Seriennummer", "SN"],
    "note": ["Bemerkung", "Kommentar"],
}
UNITS = {"mm": 1.0, "µm": 0.001, "inch": 25.4, "in": 25.4, "cm": 10.0}
micrometres = st.integers(-400, 400)
rows = st.lists(
    st.tuples(st.integers(1_000, 900_000), micrometres.filter(bool), st.integers(1, 90), st.integers(-90, -1)),
    min_size=2,
    max_size=12,
)


@st.composite
def layouts(draw: st.DrawFn) -> tuple[str, str, list[str], dict[str, str], int, str]:
    """Separator, decimal mark, order of the columns, their headings, rows above them, the unit."""
    separator = draw(st.sampled_from("\t;|,"))
    decimal = "." if separator == "," else draw(st.sampled_from(".,"))
    order = draw(st.permutations(list(HEADINGS)))
    lower = draw(st.sampled_from(HEADINGS["lower"]))
    headings = {key: draw(st.sampled_from(names)) for key, names in HEADINGS.items()} | {"lower": lower}
    if "UT" in (headings["lower"], headings["upper"]) or "OT" in headings.values():
        headings |= {"lower": "UT", "upper": "OT"}
    return separator, decimal, order, headings, draw(st.integers(0, 9)), draw(st.sampled_from(list(UNITS)))


@given(rows, layouts(), st.sampled_from(["\n", "\r\n"]), st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]))
def test_a_table_is_read_as_it_was_meant(
    values: list[tuple[int, int, int, int]],
    layout: tuple[str, str, list[str], dict[str, str], int, str],
    newline: str,
    encoding: str,
) -> None:
    separator, decimal, order, headings, above, unit = layout
    factor = UNITS[unit]

    def number(micrometre: float) -> str:
        return f"{micrometre / 1000 / factor:.9f}".replace(".", decimal)

    lines = ["protocol"] * above
    lines.append(
        separator.join(headings[key] + ("" if key in ("name", "serial", "note") else f" [{unit}]") for key in order)
    )
    for k, (nominal, deviation, upper, lower) in enumerate(values):
        cells = {
            "name": f"D{k}",
            "nominal": number(nominal),
            "actual": number(nominal + deviation),
            "deviation": number(deviation),
            "upper": number(upper),
            "lower": number(lower),
            "serial": f"S{k % 2}",
            "note": "",
        }
        lines.append(separator.join(cells[key] for key in order))
    readings = _read(newline.join([*lines, ""]).encode(encoding))
    assert len(readings) == len(values)
    for one in readings:
        nominal, deviation, upper, lower = values[int(one.characteristic[1:])]
        expected = (nominal + deviation, nominal, nominal + lower, nominal + upper)
        found = (one.actual, one.nominal, one.lower_limit, one.upper_limit)
        assert found == pytest.approx([value / 1000 for value in expected], abs=1e-7)


def _read(content: bytes) -> list[Reading]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        path.write_bytes(content)
        file = read_measured_file(path, StatedFacts())
    assert {one.part.serial for one in file.inspections} == {"S0", "S1"}
    assert not [remark for remark in file.remarks if "deviations" in remark.text]
    return [reading for one in file.inspections for reading in one.readings]
