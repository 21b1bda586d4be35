"""Temporary folders of the examples: corrections are looked for in folders near a job, which are of the test too."""

import tempfile
from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def folders_of_the_test(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
