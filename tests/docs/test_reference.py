"""The pages of reference are those that the code makes, and leave nothing out."""

import re

import pytest

import trueloop
from scripts import file_keys_page, http_page, probe_log_example, python_page
from scripts.manual.contents import ROOT
from scripts.web_shapes import openapi
from tests.support.toml_files import KINDS
from trueloop.described import meanings
from trueloop.formats.examples import example
from trueloop.formats.measurements.touches_csv import KNOWN, read_touches
from trueloop.jobs.measure.probing import read_probing

COMPARED = {  # a page that takes figures over, and the pages that have them
    "bands.md": ("measurements.md", "nist-parts.md", "nist-memory.md", "surface-study.md"),
    "../README.md": ("nist-parts.md", "nist-memory.md", "realtime-demo.md", "measurements.md", "surface-study.md"),
}


def test_the_log_of_the_example_is_the_one_that_its_script_makes() -> None:
    log = probe_log_example.LOG.read_text(encoding="utf-8")
    assert log == probe_log_example.log(), "run: python -m scripts.probe_log_example"


def test_every_stable_name_has_an_entry() -> None:
    entries = re.findall(r"^### `(\w+)`$", python_page.page(), re.M)
    assert sorted(entries) == sorted(set(dir(trueloop)) - {"__version__"})


def test_every_key_of_every_file_says_what_it_means() -> None:
    """A table is described by its keys, a key by the text below it."""
    kinds = set(file_keys_page.TITLES) | set(file_keys_page.ELSEWHERE)
    assert kinds == set(KINDS)
    for kind, file in KINDS.items():
        for heading, model in file_keys_page.tables(file, ""):
            for key, one in model.model_fields.items():
                assert key in meanings(model) or file_keys_page.inner(one.annotation), (kind, heading, key)


def test_every_address_has_a_row() -> None:
    rows = re.findall(r"^\| `([A-Z]+ /\S*)` \|", http_page.page(), re.M)
    asked = [
        f"{method.upper()} {path.removeprefix('/api/v1')}"
        for path, node in openapi()["paths"].items()
        for method in node
    ]
    assert sorted(rows) == sorted(asked) and len(asked) > 40


def test_every_column_of_touches_is_on_its_page() -> None:
    page = (ROOT / "docs" / "touches.md").read_text(encoding="utf-8")
    rows = [line.split(" | ")[0] for line in page.splitlines() if line.startswith("| `")]
    assert {name for row in rows for name in re.findall(r"`(\w+)`", row)} == {*KNOWN, "note"}


def test_the_log_of_the_example_gives_the_errors_that_nist_measured() -> None:
    """By plain geometry: how far the logged centre lies from the nominal point along the normal, less ball and
    stock."""
    errors = {touch.point: touch.error_mm for touch in read_touches(example("modbas2/touches.csv"))}
    plan = read_probing(example("loop/modbas2.toml")).plan
    logged = [[float(word) for word in row.split()] for row in probe_log_example.LOG.read_text().splitlines()]
    assert len(logged) == len(plan.touches) == len(errors)
    for touch, (x, _, z, *_) in zip(plan.touches, logged, strict=True):
        off_mm = (x - touch.nominal_mm[0]) * touch.normal[0] + (z - touch.nominal_mm[1]) * touch.normal[1]
        assert off_mm == pytest.approx(0.254 + (errors[touch.point] or 0.0) + 1.4946, abs=0.6e-3)  # lobing: 0.5 µm


@pytest.mark.parametrize("page", COMPARED)
def test_figures_that_a_page_takes_over_stand_where_they_come_from(page: str) -> None:
    sources = "\n".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in COMPARED[page])
    table = [line for line in (ROOT / "docs" / page).read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    figures = {found for line in table for found in re.findall(r"\d+\.\d+", line)}
    assert len(figures) >= 5 and sorted(one for one in figures if one not in sources) == []
