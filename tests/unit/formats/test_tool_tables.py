"""Tool tables of controls: read by hand arithmetic, and written back with nothing changed but the number."""

from dataclasses import replace
from decimal import Decimal
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.tool_tables import FANUC, HAAS, HEIDENHAIN, LINUXCNC, OFFSET, SIEMENS
from trueloop.errors import Code, TrueloopError
from trueloop.formats.tables.tool_tables.known import (
    KNOWN,
    geometry_of,
    new_table,
    nose_radius_mm,
    read_tool_table,
    row_of,
)
from trueloop.formats.tables.tool_tables.tool_table import ToolTable, Unit

NAMES = {"tool.tbl": LINUXCNC, "fanuc.txt": FANUC, "a.ofs": HAAS, "to.ini": SIEMENS, "toolturn.trn": HEIDENHAIN}
WRITTEN = [name for name in NAMES if name != "a.ofs"]


def table(folder: Path, name: str, text: str | None = None, unit: Unit | None = "mm") -> ToolTable:
    path = folder / name
    path.write_bytes((NAMES[name] if text is None else text).encode())
    return read_tool_table(path, unit)


def numbers(of: ToolTable, tool: int = 3) -> tuple[str, Decimal | None, Decimal | None]:
    row = row_of(of, tool)
    x, z = (None if number is None else number.value for number in (row.x, row.z))
    return row.kind, x, z


@pytest.mark.parametrize(
    ("name", "kind", "x", "z", "nose_mm", "tip", "called"),
    [
        ("tool.tbl", "geometry", "12.5", "-3.25", 0.4, 2, "finish DNMG"),
        ("fanuc.txt", "wear", "-0.1", "0.05", 0.8, 3, ""),
        ("a.ofs", "wear", "-0.02", "0.01", None, None, ""),
        ("to.ini", "wear", "-0.05", "0", 0.4, 3, "FINISHER"),
        ("toolturn.trn", "wear", "-0.05", "0.01", 0.4, 2, "FINISH"),
    ],
)
def test_each_control_keeps_tool_3_in_its_own_way(
    tmp_path: Path, name: str, kind: str, x: str, z: str, nose_mm: float | None, tip: int | None, called: str
) -> None:
    read = table(tmp_path, name)
    assert numbers(read) == (kind, Decimal(x), Decimal(z))
    row = row_of(read, 3)
    assert (row.name, geometry_of(read, row).tip) == (called, tip)
    if nose_mm is not None:
        assert nose_radius_mm(read, 3, 1, "", None) == pytest.approx(nose_mm, abs=1e-12)


@pytest.mark.parametrize(
    ("name", "old_and_new", "added"),
    [
        # X a radius: −0.012. D, the nose, stays.
        ("tool.tbl", [("X+12.500000", "X+12.488000"), ("Z-3.25 ", "Z-3.24600 ")], " trueloop offset ID"),
        # X a diameter as the program's words: −0.024.
        ("fanuc.txt", [("P3 X-0.1 Z.05", "P3 X-0.124 Z0.054")], " (trueloop offset ID)"),
        # Length 1 is a radius.
        ("to.ini", [("DP12[3,1]=-0.050", "DP12[3,1]=-0.0620"), ("DP13[3,1]=0.000", "DP13[3,1]=0.0040")], ""),
        ("toolturn.trn", [("+0.01     -0.05     ", "+0.0140   -0.0620   ")], ""),
    ],
)
def test_only_the_tools_numbers_change(
    tmp_path: Path, name: str, old_and_new: list[tuple[str, str]], added: str
) -> None:
    text = NAMES[name]
    for old, new in old_and_new:
        assert text.count(old) == 1
        text = text.replace(old, new)
    written = new_table(table(tmp_path, name), OFFSET, "ID").content.decode()
    assert written.replace(added.replace("ID", f"ID of {'1' * 16}"), "") == text
    assert len(written) - len(text) == (len(added) + len(" of ") + 16 if added else 0)


@pytest.mark.parametrize("name", WRITTEN)
@pytest.mark.parametrize("unit", ["mm", "inch"])
def test_a_reader_finds_the_change_in_the_tables_unit(tmp_path: Path, name: str, unit: Unit) -> None:
    """Of the radius 12 µm inwards and of z 4 µm outwards, whatever the table counts in."""
    text = NAMES[name].replace("METRIC", "INCH") if unit == "inch" else NAMES[name]
    text = text.replace("TRN MM", "TRN INCH").replace("G21", "G20") if unit == "inch" else text
    before = table(tmp_path, name, text, unit)
    after = table(tmp_path, name, new_table(before, OFFSET, "ID").content.decode(), unit)
    per_mm = 1 / 25.4 if unit == "inch" else 1.0
    factor = 2 if name == "fanuc.txt" else 1
    (_, x, z), (_, new_x, new_z) = numbers(before), numbers(after)
    assert None not in (x, z, new_x, new_z)
    step = float(before.step)
    assert float((new_x or 0) - (x or 0)) == pytest.approx(-0.012 * factor * per_mm, abs=step / 2)
    assert float((new_z or 0) - (z or 0)) == pytest.approx(0.004 * per_mm, abs=step / 2)
    assert step < 0.003 * per_mm


def test_a_fanuc_that_reads_radii_gets_the_radius(tmp_path: Path) -> None:
    written = new_table(table(tmp_path, "fanuc.txt"), replace(OFFSET, x_is="radius"), "ID").content
    assert b"P3 X-0.112 Z0.054" in written


def test_numbers_without_a_point_count_least_increments(tmp_path: Path) -> None:
    """Geometry 3, X-155500: −155.5 mm, or −15.55 inch of four decimals."""
    for unit, text, x in (("mm", FANUC, "-155.5"), ("inch", FANUC.replace("G21", "G20"), "-15.55")):
        found = next(
            row for row in table(tmp_path, "fanuc.txt", text, None).rows if (row.tool, row.kind) == (3, "geometry")
        )
        assert found.x is not None and found.x.value == Decimal(x), unit


def test_wear_of_a_lathe_in_linuxcnc_is_where_the_table_has_it(tmp_path: Path) -> None:
    text = LINUXCNC + "\nT10003 P9 X0.001 Z0.001 D0.8 Q2\n"
    read = table(tmp_path, "tool.tbl", text)
    assert numbers(read) == ("wear", Decimal("0.001"), Decimal("0.001"))
    assert geometry_of(read, row_of(read, 3)).line == 3
    assert b"T10003 P9 X-0.01100 Z0.00500 D0.8" in new_table(read, OFFSET, "ID").content


def test_a_row_of_linuxcnc_without_x_gets_one(tmp_path: Path) -> None:
    written = new_table(table(tmp_path, "tool.tbl"), replace(OFFSET, tool=1), "ID").content.decode()
    assert "Q1 X-0.01200 ;rough" in written and "Z+0.104000 I" in written


def test_a_sum_of_zero_is_written_as_zero(tmp_path: Path) -> None:
    text = LINUXCNC.replace("X+12.500000", "X+0.012")
    assert b"X+0.00000 Z" in new_table(table(tmp_path, "tool.tbl", text), OFFSET, "ID").content


@given(
    x=st.decimals(-999, 999, places=4), z=st.decimals(-999, 999, places=4), dx=st.integers(-150, 150), dz=st.integers()
)
def test_what_is_added_and_taken_away_again_leaves_the_values(x: Decimal, z: Decimal, dx: int, dz: int) -> None:
    """Reading what was written gives the old value and the change, for every format that is written."""
    there = replace(OFFSET, x_radius_mm=dx / 1000, z_mm=dz % 150 / 1000)
    texts = {
        "tool.tbl": f"T3 X{x} Z{z} D1 ;a\n",
        "to.ini": f"METRIC\n$TC_DP1[3,1]=500\n$TC_DP12[3,1]={x}\n$TC_DP13[3,1]={z}\n",
        "fanuc.txt": f"G21\nG10 P3 X{x} Z{z}\n",
    }
    for name, text in texts.items():
        read = next(read for recognises, read in KNOWN if recognises(Path(name), text.encode()))
        before = replace(read(Path(name), text, "mm"), unit="mm")
        after = read(Path(name), new_table(before, there, "ID").content.decode(), "mm")
        factor = 2 if name == "fanuc.txt" else 1
        assert numbers(after)[1:] == (x + factor * Decimal(dx).scaleb(-3), z + Decimal(dz % 150).scaleb(-3))


@pytest.mark.corpus
def test_tables_of_real_machines(corpus: Path) -> None:
    folder = corpus / "data/public/offsets"
    mill = read_tool_table(folder / "linuxcnc-mill-mm.tbl", "mm")
    assert [row.tool for row in mill.rows] == list(range(1, 25)) and mill.rows[3].name == "16 mm schaftfräser"
    assert mill.rows[0].nose is not None and mill.rows[0].nose.value == 3
    worn = read_tool_table(folder / "linuxcnc-lathe-wear.tbl", "inch")
    assert numbers(worn, 1) == ("wear", Decimal("0.001"), Decimal("0.001"))
    sinumerik = read_tool_table(folder / "siemens-tools-and-zeros.ini")
    assert len({row.tool for row in sinumerik.rows}) == 15 and sinumerik.unit == "mm"
    assert sinumerik.rows[0].name == "CUTTER 4" and sinumerik.rows[0].others["DP6"] == "2.000"
    for name, tool in (("linuxcnc-lathe.tbl", 6), ("linuxcnc-lathe-wear.tbl", 2), ("linuxcnc-mill-mm.tbl", 4)):
        read = read_tool_table(folder / name, "mm")
        written = new_table(read, replace(OFFSET, tool=tool), "ID").content
        lines = list(zip((folder / name).read_bytes().split(b"\n"), written.split(b"\n"), strict=True))
        assert sum(old != new for old, new in lines) == 1


def test_the_nose_of_a_table_in_inch_is_told_in_mm(tmp_path: Path) -> None:
    """D0.0625 of LinuxCNC, a diameter, and DP6 0.03125, a radius: 1/32 inch, 0.79375 mm."""
    drawn = {
        "tool.tbl": "T3 X0 Z0 D0.0625 Q2\n",
        "to.ini": SIEMENS.replace("METRIC", "INCH").replace("0.400", "0.03125"),
    }
    for name, text in drawn.items():
        assert nose_radius_mm(table(tmp_path, name, text, "inch"), 3, 1, "", 0.79375) == pytest.approx(0.79375)


def test_an_ofs_file_names_the_line_of_a_bad_number(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as caught:
        table(tmp_path, "a.ofs", HAAS.replace("-0.02", "1.2.3"))
    assert (caught.value.code, caught.value.place.line) == (Code.OFS_NUMBER, 4)


@pytest.mark.parametrize(("name", "text"), [("tool.tbl", LINUXCNC), ("tool.tbl", "T3 X0 Z0\n"), ("fanuc.txt", FANUC)])
def test_the_next_correction_takes_the_place_of_the_comment(tmp_path: Path, name: str, text: str) -> None:
    """And the tool keeps its name: a comment that grew would fill the row."""
    first = table(tmp_path, name, text)
    once = table(tmp_path, name, new_table(first, OFFSET, "aa").content.decode())
    again = replace(OFFSET, measured_sha256="2" * 64, x_radius_mm=0.012, z_mm=-0.004)
    twice = table(tmp_path, name, new_table(once, again, "bb").content.decode())
    assert row_of(twice, 3).name == row_of(once, 3).name == row_of(first, 3).name
    assert "trueloop offset aa" not in twice.text and twice.text.count("trueloop offset bb of 2222") == 1
    assert numbers(twice)[1:] == numbers(first)[1:]
