"""Memory that was freed between blocks still in use."""

from pathlib import Path
from typing import Final

from trueloop.server.heap import give_back

BLOCK: Final = 4000  # bytes: the C library's heap, neither Python's own pools nor pages mapped for one block
MIB: Final = 1 << 20


def _resident_mib() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / MIB


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
