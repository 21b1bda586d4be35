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
