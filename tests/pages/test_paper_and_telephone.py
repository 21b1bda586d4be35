"""The report as PDF, and in a window of 400 px: nothing runs over the edge, nothing stays folded, text is legible."""

import re
import subprocess
from itertools import pairwise
from pathlib import Path
from shutil import which

import pytest

from tests.support.chromium import dump_dom
from tests.support.correction import example_correction
from trueloop.report.pdf import as_pdf
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.page import page

LOOK = """<script>
const frame = document.querySelector("iframe");
frame.addEventListener("load", () => {
  const inside = frame.contentDocument;
  const shown = (one) => one.getClientRects().length > 0;
  const texts = [...inside.querySelectorAll("svg.still text")].filter(shown);
  const size = (one) => parseFloat(frame.contentWindow.getComputedStyle(one).fontSize);
  const scale = (one) => Math.hypot(one.getScreenCTM().a, one.getScreenCTM().b) * size(one);
  document.body.dataset.wide = inside.documentElement.scrollWidth;
  document.body.dataset.least = Math.min(...texts.map(scale));
  document.body.dataset.figures = [...inside.querySelectorAll("svg.still")].filter(shown).length;
  document.body.dataset.levels = [...inside.querySelectorAll("h1,h2,h3")].map((one) => one.tagName[1]).join("");
});
</script>"""


@pytest.fixture(scope="module")
def german(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("telephone") / "report.html"
    file.write_text(page(example_correction("modbas2"), Texts("de", "mm")), encoding="utf-8")
    return file


def test_at_400_px_nothing_runs_over_the_edge_and_figures_are_legible(german: Path) -> None:
    look = german.with_name("look.html")
    content = german.read_text(encoding="utf-8").replace("&", "&amp;").replace('"', "&quot;")
    frame = f'<iframe srcdoc="{content}" style="width:400px;height:8000px;border:0"></iframe>'
    look.write_text(f"<!doctype html><body>{frame}{LOOK}</body>", encoding="utf-8")
    body = re.search(r"<body ([^>]*)>", dump_dom(look))
    assert body is not None
    seen = dict(re.findall(r'data-(\w+)="([^"]*)"', body[1]))
    assert int(seen["wide"]) <= 400
    assert float(seen["least"]) >= 9  # px on the screen
    assert int(seen["figures"]) == 6  # each figure once
    levels = [int(level) for level in seen["levels"]]
    assert levels[0] == 1 and all(b - a <= 1 for a, b in pairwise(levels))


def test_the_pdf_is_a4_and_says_what_is_folded_on_a_screen(german: Path, tmp_path: Path) -> None:
    pdf = as_pdf(german.read_text(encoding="utf-8"))
    boxes = {tuple(map(float, box.split())) for box in re.findall(rb"/MediaBox \[([^\]]*)\]", pdf)}
    assert {(round(right * 25.4 / 72), round(top * 25.4 / 72)) for _, _, right, top in boxes} == {(210, 297)}
    file = tmp_path / "report.pdf"
    file.write_bytes(pdf)
    if pdftotext := which("pdftotext"):
        text = subprocess.run([pdftotext, "-layout", file, "-"], capture_output=True, text=True, check=True).stdout
        correction = example_correction("modbas2")
        assert re.search(rf"MODBAS2, 3.52 in – Korrektur {correction.record.id} +1 / \d", text)
        for line in correction.corrected_program.decode().splitlines()[33:48]:
            assert " ".join(line.split()) in " ".join(text.split())
