"""What every reader of a CSV file says of columns, rows and lines, whichever it is."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.support.machines import chain_with_travel
from tests.support.refusals import refused
from trueloop.errors import Code
from trueloop.formats.measurements.field_csv import read_field
from trueloop.formats.measurements.history_csv import read_drift, read_history
from trueloop.formats.measurements.inspections_csv import read_inspections
from trueloop.formats.measurements.positioning_data import read_positioning
from trueloop.formats.measurements.readings_csv import read_readings
from trueloop.formats.measurements.surface_csv import read_points
from trueloop.formats.measurements.touches_csv import read_touches

PLACES = ",".join(f"{kind}_{c}_mm" for kind in ("nominal", "controller", "cmm") for c in "xyz")


@dataclass(frozen=True)
class Kind:
    """A reader, a file of two rows that it takes, the place of a column of numbers, and its codes."""

    read: Callable[[Path], object]
    header: str
    rows: tuple[str, str]
    number: int
    codes: frozenset[Code]


MACHINE = frozenset({Code.MCH_FILE})
KINDS = {
    "touches": Kind(
        read_touches,
        "point,nominal_x_mm,nominal_z_mm,error_um",
        ("1,40,5,3", "2,40,6,4"),
        3,
        frozenset({Code.TCH_COLUMN, Code.TCH_NUMBER}),
    ),
    "readings": Kind(
        lambda path: read_readings(path, chain_with_travel("mill-gantry")),
        "X_mm,along,reading_um",
        ("0,X,1", "10,X,2"),
        2,
        MACHINE,
    ),
    "history": Kind(read_history, "time_s,T1_degC", ("0,20", "60,21"), 1, MACHINE),
    "drift": Kind(read_drift, "time_s,T1_degC,EX_um", ("0,20,0", "60,21,1"), 2, MACHINE),
    "inspections": Kind(
        read_inspections,
        f"{PLACES},normal_x,normal_y,normal_z",
        ("1,2,3,1,2,3,1,2,3,0,0,1", "4,5,6,4,5,6,4,5,6,0,0,1"),
        8,
        MACHINE,
    ),
    "positioning": Kind(
        read_positioning,
        "target_mm,approach,cycle,actual_mm",
        ("0,up,1,0\n0,down,1,0\n0,up,2,0\n0,down,2,0\n9,up,1,9\n9,down,1,9", "9,up,2,9\n9,down,2,9"),
        3,
        MACHINE,
    ),
    "points": Kind(read_points, "row,column,x_mm,y_mm,z_mm", ("1,1,0,0,0", "1,2,1,0,0"), 4, frozenset({Code.SRF_FILE})),
    "field": Kind(read_field, "x_mm,dx_um", ("0,1", "10,2"), 1, frozenset({Code.NC_FIELD})),
}
each_kind = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "data.csv"


def _lines(path: Path, *lines: str) -> Path:
    path.write_text("\n".join([*lines, ""]))
    return path


@each_kind
def test_comments_empty_lines_blanks_and_a_column_of_notes_are_passed_over(kind: Kind, path: Path) -> None:
    noted = [",".join([line, " seen "]) for row in kind.rows for line in row.split("\n")]
    kind.read(_lines(path, "# made", "", f" {kind.header.replace(',', ' , ')},note,", "  # rows", *noted, " "))


@each_kind
def test_semicolons_with_decimal_commas(kind: Kind, path: Path) -> None:
    kind.read(_lines(path, *(line.replace(",", ";").replace("3", "3,0") for line in (kind.header, *kind.rows))))


@each_kind
def test_a_column_given_twice_is_refused(kind: Kind, path: Path) -> None:
    names = kind.header.split(",")
    doubled = [f"{line},{line.split(',')[kind.number]}" for row in kind.rows for line in row.split("\n")]
    refusal = refused(kind.read, _lines(path, "# made", f"{kind.header},{names[kind.number]}", *doubled))
    assert refusal.code in kind.codes
    assert (refusal.place.line, refusal.place.column) == (2, len(names) + 1)
    assert f"{names[kind.number]!r} is there 2 times" in refusal.message


@each_kind
def test_a_mistyped_column_is_refused_with_the_name_it_is_like(kind: Kind, path: Path) -> None:
    """In place of nothing: a column more, which would be ignored."""
    refusal = refused(kind.read, _lines(path, f"{kind.header},noet", *(f"{row},1" for row in kind.rows)))
    assert refusal.code in kind.codes
    assert "'noet' is not one of" in refusal.message


@each_kind
@pytest.mark.parametrize("cell", ["", "ten", "nan", "inf", "1e300"])
def test_what_is_no_number_is_told_with_its_line_and_column(kind: Kind, path: Path, cell: str) -> None:
    cells = kind.rows[1].split("\n")[-1].split(",")
    cells[kind.number] = cell
    before = [*kind.rows[0].split("\n"), *kind.rows[1].split("\n")[:-1]]
    refusal = refused(kind.read, _lines(path, "", "# made", kind.header, *before, "# then", "", ",".join(cells)))
    assert refusal.code in kind.codes
    assert (refusal.place.file, refusal.place.line, refusal.place.column) == (
        str(path),
        len(before) + 6,
        kind.number + 1,
    )
    assert f"is {cell!r}, " in refusal.message


@each_kind
@pytest.mark.parametrize("change", [lambda row: row.rpartition(",")[0], lambda row: row + ",1", lambda row: '"' + row])
def test_rows_of_another_length_are_told_with_their_line(kind: Kind, path: Path, change: Callable[[str], str]) -> None:
    refusal = refused(kind.read, _lines(path, kind.header, change(kind.rows[0]), kind.rows[1]))
    assert refusal.code in kind.codes
    assert refusal.place.line in (2, 1 + len(kind.rows[0].split("\n")))
    assert "cells under" in refusal.message


@pytest.mark.parametrize("missing", ["row", "column"])
def test_half_a_place_on_a_grid_is_not_taken_for_scattered_points(path: Path, missing: str) -> None:
    given = "column" if missing == "row" else "row"
    refusal = refused(read_points, _lines(path, f"{given},x_mm,y_mm,z_mm", "1,0,0,0", "2,1,0,0"))
    assert refusal.code is Code.SRF_FILE and f"is {missing}" in refusal.message


def test_a_place_of_the_grid_given_twice_is_told_with_its_line(path: Path) -> None:
    refusal = refused(read_points, _lines(path, "# S01", "row,column,x_mm,y_mm,z_mm", "1,1,0,0,0", "", "1,1,1,0,0"))
    assert (refusal.code, refusal.place.line) == (Code.SRF_FILE, 5)


def test_scattered_nodes_are_refused_without_a_grid_of_them_all(path: Path) -> None:
    """Twenty thousand rows off any grid: 8e12 nodes, of which a list would take more memory than there is."""
    at = np.random.default_rng(1).permutation(20_000)
    rows = (f"{k},{at[k]},{at[-k]},1" for k in range(len(at)))
    refusal = refused(read_field, _lines(path, "x_mm,y_mm,z_mm,dx_um", *rows))
    assert refusal.code is Code.NC_FIELD
    assert f"20000 of {20_000**3} nodes" in refusal.message


def test_a_displacement_in_two_units_is_refused(path: Path) -> None:
    refusal = refused(read_field, _lines(path, "x_mm,dx_um,dx_mm", "0,1,0.001", "10,2,0.002"))
    assert refusal.code is Code.NC_FIELD and "dx_mm, dx_um" in refusal.message


def test_stated_uncertainties_and_what_the_process_took_are_in_mm(path: Path) -> None:
    header = f"{KINDS['inspections'].header},comp_proc_um"
    stated = ("# touch_u_um 0.5", "# a comment", "#cmm_u_um 0.25")
    _, seen = read_inspections(_lines(path, *stated, header, f"{KINDS['inspections'].rows[0]},5"))
    assert (seen.touch_u_mm, seen.cmm_u_mm, np.ravel(seen.comp_proc_mm).tolist()) == (0.0005, 0.00025, [0.005])


@pytest.mark.parametrize(
    ("line", "said"), [("0,up,1,0.9", "given twice"), ("0,up,1.5,0", "cycle 1.5"), ("9,Up,1,0", "approach 'Up'")]
)
def test_a_positioning_test_is_refused_where_a_row_would_be_lost(path: Path, line: str, said: str) -> None:
    kind = KINDS["positioning"]
    refusal = refused(read_positioning, _lines(path, "# test", kind.header, "0,up,1,0", "", line))
    assert (refusal.code, refusal.place.line) == (Code.MCH_FILE, 5)
    assert said in refusal.message


@pytest.mark.parametrize(
    "line", ["TGT_DATA[1]=4", "TGT_DATA[1 2]=3", "TGT_DATA[3]=", "REF_DATA_FWD[1]=3", "UNIT=mm # so", "TGT_DATA[3]=nan"]
)
def test_an_assignment_that_cannot_be_read_or_comes_twice_is_refused(path: Path, line: str) -> None:
    refusal = refused(read_positioning, _lines(path, "UNIT=mm", "NAME=x", "TGT_DATA[1]=0", "", line))
    assert (refusal.code, refusal.place.line) == (Code.MCH_FILE, 5)
