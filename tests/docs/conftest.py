"""The site of the manual, built once."""

from pathlib import Path

import pytest

from scripts.manual.site import write


@pytest.fixture(scope="session")
def manual(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with the site."""
    folder = tmp_path_factory.mktemp("manual") / "site"
    write(folder)
    return folder
