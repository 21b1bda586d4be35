"""Passes that some blocks make several times: a subprogram or a finishing cycle called by two tools, a bar loop."""

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Final

from trueloop.nc.program.feed_moves import FeedMove

SAME_PLACE_MM: Final = 1e-6


def of_one_run(
    moves: Sequence[FeedMove], stated: Callable[[FeedMove], bool]
) -> tuple[tuple[FeedMove, ...], tuple[FeedMove, ...]]:
    """Returns the feed moves without the chains that their lines repeat at equal places, and the moves left out.

    Of repeated chains the last by the job's tool (`stated`) counts, else the last of all: it leaves the surface.
    The way to the first end may differ.
    """
    chains = [list(members) for _, members in groupby(moves, key=lambda move: move.chain)]
    counts: dict[tuple[object, ...], int] = {}
    for place, chain in enumerate(chains):
        key = tuple(map(_key, chain))
        before = counts.get(key)
        if before is None or stated(chain[0]) or not stated(chains[before][0]):
            counts[key] = place
    kept = set(counts.values())
    taken, left = (
        tuple(move for place, chain in enumerate(chains) if (place in kept) is wanted for move in chain)
        for wanted in (True, False)
    )
    return taken, left


def _key(move: FeedMove) -> tuple[object, ...]:
    x, z = (round(value / SAME_PLACE_MM) for value in move.path.end_mm)
    return move.line, x, z, move.compensation
