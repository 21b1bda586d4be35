"""What the service asks of the C library's heap."""

import subprocess
import sys
from pathlib import Path
from typing import Final

from trueloop.server.heap import give_back

BLOCK: Final = 4000  # bytes: of the C library's heap, neither of Python's own pools nor pages mapped for one block
MIB: Final = 1 << 20
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


def _resident_mib() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / MIB


def _heaps(shared: bool) -> int:
    """How many the C library says that it has, when eight threads have allocated."""
    done = subprocess.run(
        [sys.executable, "-c", THREADS_ALLOCATE.format(shared=shared)],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    return done.stderr.count("Arena ")


def test_what_lies_below_a_block_in_use_goes_back() -> None:
    before = _resident_mib()
    blocks = [bytes(BLOCK) for _ in range(64 * MIB // BLOCK)]
    last = blocks[-1]
    blocks.clear()
    kept = _resident_mib() - before
    give_back()
    assert kept > 48, "the C library gives back by itself what this is for"
    assert _resident_mib() - before < 16
    assert len(last) == BLOCK


def test_threads_share_one_heap() -> None:
    assert _heaps(shared=True) == 1 < _heaps(shared=False)
