"""What the service asks of the C library's heap; each in a process of its own, as other tests leave heaps and holes."""

import ctypes
import subprocess
import sys
from typing import Final

import pytest

from trueloop.server import heap

BLOCK: Final = 4000  # bytes: of the C library's heap, neither of Python's own pools nor pages mapped for one block
HOLES: Final = f"""
from pathlib import Path
from resource import getpagesize
from trueloop.server.heap import give_back

def resident_mib():
    return int(Path("/proc/self/statm").read_text().split()[1]) * getpagesize() / 2**20

before = resident_mib()
blocks = [bytes({BLOCK}) for _ in range(64 * 2**20 // {BLOCK})]
last = blocks[-1]
blocks.clear()
kept = resident_mib() - before
give_back()
print(kept, resident_mib() - before, len(last))
"""
THREADS_ALLOCATE: Final = f"""
import ctypes, threading
from trueloop.server import heap

if {{shared}}:
    heap.share_one()
barrier, held = threading.Barrier(8), []

def allocate():
    barrier.wait(30)
    held.append([bytes({BLOCK}) for _ in range(100)])
    barrier.wait(30)

threads = [threading.Thread(target=allocate) for _ in range(8)]
for one in threads:
    one.start()
for one in threads:
    one.join()
ctypes.CDLL(None).malloc_stats()
"""


def _run(program: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", program]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)


def _heaps(shared: bool) -> int:
    """How many the C library says that it has, when eight threads have allocated."""
    return _run(THREADS_ALLOCATE.format(shared=shared)).stderr.count("Arena ")


def test_what_lies_below_a_block_in_use_goes_back() -> None:
    kept_mib, left_mib, _ = map(float, _run(HOLES).stdout.split())
    assert kept_mib > 48, "the C library gives back by itself what this is for"
    assert left_mib < 16


def test_threads_share_one_heap() -> None:
    assert _heaps(shared=True) == 1 < _heaps(shared=False)


def test_on_windows_no_library_is_looked_into(monkeypatch: pytest.MonkeyPatch) -> None:
    """`CDLL(None)`, the program itself, is a TypeError there."""
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(ctypes, "CDLL", None)
    heap.share_one()
    heap.give_back()
