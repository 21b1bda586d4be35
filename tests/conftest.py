"""What every test may ask for: real data given with `--corpus`, and how hypothesis searches."""

import copy
import os
import signal
from collections.abc import Generator, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

from tests.support import postgresql

settings.register_profile("desk", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, database=None, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "desk")

LONGEST = "test_simulated.py"
"""Its studies take a tenth of the whole run, one after the other: begun last, they would be waited for."""

LONGEST_S = 900
"""No test takes this long, not even beside other work: one that waits for ever fails and names where it waits."""

for ignored in (signal.SIGINT, signal.SIGQUIT, signal.SIGTERM, signal.SIGHUP):
    # Under `nohup`, in the background of a shell and on many CI runners signals are ignored, and children inherit that:
    # a command that is to be interrupted would never hear of it.
    if signal.getsignal(ignored) is signal.SIG_IGN:
        signal.signal(ignored, signal.default_int_handler if ignored == signal.SIGINT else signal.SIG_DFL)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.name != LONGEST)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Every generator of random numbers that a test's module holds begins anew: no test depends on those before it."""
    for found in vars(getattr(item, "module", None) or object).values():
        if isinstance(found, np.random.Generator):
            bits = found.bit_generator
            bits.state = _BEGINNINGS.setdefault(id(bits), (bits, copy.deepcopy(bits.state)))[1]


_BEGINNINGS: dict[int, tuple[np.random.BitGenerator, Any]] = {}
"""Generators and their states at the first test of their modules; held, so that no other gets the same identity."""


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol() -> Generator[None, object, object]:
    """Every wait ends, those of fixtures among them."""
    before = signal.signal(signal.SIGALRM, _late)
    signal.alarm(LONGEST_S)
    try:
        return (yield)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def _late(signum: int, frame: FrameType | None) -> None:
    raise TimeoutError(f"the test did not end within {LONGEST_S} s")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--corpus", type=Path, metavar="DIR", help="folder that holds data/: real programs and measurements"
    )


@pytest.fixture
def tmp_path(tmp_path: Path) -> Path:
    """A folder whose neighbours are of this test too: corrections are looked for in folders near a job."""
    folder = tmp_path / "job"
    folder.mkdir()
    return folder


@pytest.fixture(scope="session")
def server() -> Iterator[postgresql.Server]:
    """PostgreSQL, started once by each process of tests: its folder alone takes a second to make."""
    with postgresql.running() as started:
        yield started


@pytest.fixture(scope="session")
def corpus(request: pytest.FixtureRequest) -> Path:
    """The folder that holds `data/`. Its tests are marked `corpus` and fail without the folder."""
    folder: Path | None = request.config.getoption("--corpus")
    if folder is None:
        pytest.fail("this test reads real data: run  make test-corpus CORPUS=DIR", pytrace=False)
    if not (folder / "data").is_dir():
        pytest.fail(f"--corpus {folder} holds no folder data/", pytrace=False)
    return folder.resolve()
