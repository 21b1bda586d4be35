"""`trueloop measure sheet` from the outside."""

import csv
from pathlib import Path

from tests.support.cli import run

EXAMPLES = Path(__file__).parents[3] / "examples"
ASKED = """
[[part.characteristic]]
name = "seat"
quantity = "diameter"
feature = "main-cylinder"
tolerance = "±0.001"

[[part.characteristic]]
name = "shoulder"
quantity = "length"
feature = "step-face"
other = "main-face"
tolerance = "±0.005"
"""


def job(folder: Path) -> Path:
    """The LinuxCNC example in another folder, with two characteristics."""
    text = (EXAMPLES / "linuxcnc" / "job.toml").read_text(encoding="utf-8")
    text = text.replace('"finish.ngc"', f'"{EXAMPLES}/linuxcnc/finish.ngc"').replace("\n[tool]", f"{ASKED}\n[tool]")
    (folder / "job.toml").write_text(text, encoding="utf-8")
    return folder / "job.toml"


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def test_a_characteristic_is_measured_where_there_is_room_within_its_limits(tmp_path: Path) -> None:
    """By hand: Ø 3.52 ± 0.001 in at three places of the long cylinder; 6.135 − 1.76 = 4.375 ± 0.005 in."""
    found = rows(run("measure", "sheet", job(tmp_path)))
    seat = [row for row in found if row["characteristic"].startswith("seat")]
    assert len(seat) == 3 and {row["feature"] for row in seat} == {"main-cylinder"}
    assert {(row["lower_limit"], row["upper_limit"]) for row in seat} == {("3.51900", "3.52100")}
    (shoulder,) = [row for row in found if row["quantity"] == "length"]
    assert [float(shoulder[name]) for name in ("lower_limit", "nominal", "upper_limit")] == [4.37, 4.375, 4.38]
    assert {row["feature"] for row in found} == {"collar", "step-face", "main-cylinder", "small-cylinder"}
    assert all(row["value_in"] == "" for row in found)


def test_the_page_has_each_place_in_the_drawing_and_in_the_table(tmp_path: Path) -> None:
    path, page = job(tmp_path), tmp_path / "sheet.html"
    run("measure", "sheet", path, "-o", page)
    text, count = page.read_text(encoding="utf-8"), len(rows(run("measure", "sheet", path)))
    assert text.count("<tr>") == 2 + 1 + count  # two headings, the stated fields, the places
    assert all(f">{number}</" in text for number in range(1, count + 1))


def test_a_job_is_not_written_over(tmp_path: Path) -> None:
    path = job(tmp_path)
    before = path.read_bytes()
    assert "OUT-INPUT" in run("measure", "sheet", path, "-o", path, status=4)
    assert path.read_bytes() == before


def test_on_paper_it_is_one_a4_document(tmp_path: Path) -> None:
    path = tmp_path / "sheet.pdf"
    run("measure", "sheet", job(tmp_path), "-o", path)
    content = path.read_bytes()
    assert (content.startswith(b"%PDF-") and b"/MediaBox [0 0 595" in content) or b"/MediaBox [0 0 594.9" in content
