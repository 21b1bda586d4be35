"""docs/python.md names what there is; examples/notebook.py runs, and gives what the inputs are known to hold."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

import trueloop

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
KNOWN_UM = (12.0, -2.0, 6.5)
"""E at X 300, Y 100, Z −100 and 25 °C of the machine in examples/machine, by its README."""


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


def test_the_page_names_every_stable_name_it_calls() -> None:
    assert set(re.findall(r"trueloop\.([A-Za-z_]+)\(", PAGE)) <= set(dir(trueloop))


def test_the_notebook_runs(capsys: pytest.CaptureFixture[str]) -> None:
    cells = runpy.run_path(str(ROOT / "examples" / "notebook.py"))
    assert Path("out/notebook/corrected.nc").read_bytes() == cells["correction"].corrected_program
    assert np.allclose(cells["error_um"], KNOWN_UM, atol=0.2)
    assert "E along X: +12.0 µm" in capsys.readouterr().out
    assert cells["tables"]["journal"]["after_um"].tolist() == [26.0, 29.0, 27.0]  # the actual sizes less 24 mm


def test_a_table_has_columns_for_fields_of_fields_and_a_row_for_each_value() -> None:
    planned = trueloop.plan_measurements(trueloop.example("shaft/job.toml"), 2)
    frame = trueloop.to_frame([planned.plan, planned.plan])
    assert len(frame) == 2
    assert len(frame["chosen"][0]) == 2
    features = trueloop.feature_summaries(trueloop.compensate_job(trueloop.example("modbas2/job.toml"), "o")[0])
    table = trueloop.to_frame(features)
    assert table["figures.touches"].sum() == sum(feature.figures.touches for feature in features)


def test_a_corrected_part_shows_each_edge_with_its_features_in_a_notebook() -> None:
    part = trueloop.compensate_part(trueloop.example("grooved/grooved.toml"), "out", store=False)
    lines = repr(part).splitlines()
    assert [line.partition(":")[0] for line in lines] == [edge.tool for edge in part.edges]
    shown = part._repr_html_()
    assert shown.count('<svg class="still"') == shown.count("<table") == len(part.edges)
    corrections = [edge.correction for edge in part.edges if edge.correction is not None]
    assert len(corrections) == len(part.edges)
    assert all(feature.expected in shown for one in corrections for feature in trueloop.feature_summaries(one))
