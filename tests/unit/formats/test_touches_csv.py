"""Touches as people save them: units, diameters, separators, decimal commas, comments."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.refusals import refused
from trueloop.domain.inspection import Touch
from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.touches_csv import ERROR_COLUMNS, X_SUFFIXES, Z_SUFFIXES, read_touches

IN_ONE_MM = {"x_mm": 1.0, "x_in": 1 / 25.4, "x_diameter_mm": 2.0, "x_diameter_in": 2 / 25.4}
PLAIN = "point,feature,nominal_x_mm,nominal_z_mm,error_um\n"


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("touches") / "touches.csv"


def _read(path: Path, text: str) -> list[Touch]:
    path.write_bytes(text.encode())
    return read_touches(path)


def _refusal(path: Path, text: str) -> TrueloopError:
    return refused(_read, path, text)


@given(
    x=st.floats(0, 500),
    z=st.floats(-500, 500),
    x_column=st.sampled_from(sorted(X_SUFFIXES)),
    z_column=st.sampled_from(sorted(Z_SUFFIXES)),
)
def test_every_spelling_of_a_point_reads_as_mm_and_radius(
    path: Path, x: float, z: float, x_column: str, z_column: str
) -> None:
    """Written by factors of the test's own; a diameter is twice the radius, an inch 25.4 mm."""
    x_text = repr(x * IN_ONE_MM[x_column])
    z_text = repr(z / 25.4 if z_column == "z_in" else z)
    text = (
        f"point,nominal_{x_column},nominal_{z_column},measured_{x_column},measured_{z_column}\n"
        f"1,{x_text},{z_text},{x_text},{z_text}\n"
    )
    (touch,) = _read(path, text)
    assert touch.nominal_mm == pytest.approx((x, z), rel=1e-15, abs=1e-300)
    assert touch.measured_mm == touch.nominal_mm
    assert touch.error_mm is None
    assert touch.feature is None


@pytest.mark.parametrize(
    "column, one_mm", [("error_um", "1000"), ("error_mm", "1"), ("error_in", "0.03937007874015748")]
)
def test_errors_read_as_mm(path: Path, column: str, one_mm: str) -> None:
    assert column in ERROR_COLUMNS
    (touch,) = _read(path, f"point,nominal_x_mm,nominal_z_mm,{column}\n1,40,5,-{one_mm}\n")
    assert touch.error_mm == pytest.approx(-1.0, rel=1e-15)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_spreadsheet_with_decimal_commas(path: Path, separator: str) -> None:
    text = f"\ufeff{PLAIN}# the dome\r\n\r\n1,dome,63.87211,-149.1631,90.297\r\n".replace(",", separator)
    (touch,) = _read(path, text.replace(".", ","))
    assert touch == Touch("1", (63.87211, -149.1631), "dome", error_mm=0.090297, line=4)


def test_quoted_cells_and_spaces(path: Path) -> None:
    (touch,) = _read(path, PLAIN + '"7", "dome" , 1.5 ,2.5,3\n')
    assert (touch.point, touch.nominal_mm) == ("7", (1.5, 2.5))


@pytest.mark.parametrize("cell", ["", "nan", "NaN", "inf", "-inf", "ten", "1.5 mm", "1e999", "--3", "1e300"])
@pytest.mark.parametrize("column", [3, 4, 5])
def test_what_is_no_finite_number_is_refused_with_line_and_column(path: Path, cell: str, column: int) -> None:
    cells = ["1", "dome", "63.87", "-149.16", "90.3"]
    cells[column - 1] = cell
    refusal = _refusal(path, f"# comment\n{PLAIN}0,dome,64,-149,90\n{','.join(cells)}\n")
    assert refusal.code is Code.TCH_NUMBER
    assert (refusal.place.file, refusal.place.line, refusal.place.column) == (str(path), 4, column)


def test_a_quote_that_is_not_closed_ends_with_its_line(path: Path) -> None:
    refusal = _refusal(path, PLAIN + '1,"dome,63.87,-149.16,90.3\n2,dome,64,-149,90\n')
    assert (refusal.code, refusal.place.line) == (Code.TCH_NUMBER, 2)
    assert "2 cells under 5 columns" in refusal.message


def test_a_row_cut_short_is_refused_at_the_first_cell_it_lacks(path: Path) -> None:
    refusal = _refusal(path, PLAIN + "1,dome,63.87\n")
    assert (refusal.code, refusal.place.line, refusal.place.column) == (Code.TCH_NUMBER, 2, 4)


def test_decimal_commas_between_commas_are_refused_not_misread(path: Path) -> None:
    refusal = _refusal(path, PLAIN + "1,dome,63,87,-149,16,90,3\n")
    assert (refusal.code, refusal.place.line) == (Code.TCH_COLUMN, 2)
    assert "8 cells under 5 columns" in refusal.message


@pytest.mark.parametrize(
    "header",
    [
        "point,feature,nominal_x,nominal_z,error_um",
        "point,nominal_x_mm,nominal_z_mm",
        "point,nominal_x_mm,error_um",
        "feature,nominal_x_mm,nominal_z_mm,error_um",
        "point,nominal_x_mm,nominal_x_in,nominal_z_mm,error_um",
    ],
)
def test_a_header_that_does_not_say_all_is_refused_at_line_1(path: Path, header: str) -> None:
    refusal = _refusal(path, f"{header}\n{','.join('1' for _ in header.split(','))}\n")
    assert (refusal.code, refusal.place.line) == (Code.TCH_COLUMN, 1)


@pytest.mark.parametrize("content", [b"", b"\n# nothing\n", b"\xff\xfe\x00\x01"])
def test_a_file_without_rows_or_not_of_text_is_refused(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    assert refused(read_touches, path).code is Code.TCH_FILE


@given(st.text(max_size=200))
def test_no_text_at_all_makes_it_fail_other_than_by_refusal(path: Path, text: str) -> None:
    for start in ("", PLAIN, PLAIN.replace(",", ";")):
        try:
            _read(path, start + text.encode(errors="ignore").decode())
        except TrueloopError as refusal:
            assert refusal.code in {Code.TCH_FILE, Code.TCH_COLUMN, Code.TCH_NUMBER}
