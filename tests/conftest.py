"""What every test may ask for: real data given with `--corpus`, and how hypothesis searches."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("desk", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, database=None, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "desk")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--corpus", type=Path, metavar="DIR", help="folder that holds data/: real programs and measurements"
    )


@pytest.fixture(scope="session")
def corpus(request: pytest.FixtureRequest) -> Path:
    """The folder that holds `data/`. Its tests are marked `corpus` and fail without the folder."""
    folder: Path | None = request.config.getoption("--corpus")
    if folder is None:
        pytest.fail("this test reads real data: run  make test-corpus CORPUS=DIR", pytrace=False)
    if not (folder / "data").is_dir():
        pytest.fail(f"--corpus {folder} holds no folder data/", pytrace=False)
    return folder.resolve()
