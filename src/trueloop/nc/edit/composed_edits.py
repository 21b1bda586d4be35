"""Edits of an edited program as edits of its source."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence

from trueloop.nc.edit.edit import Edit, in_order, spliced


def composed(source: bytes, first: Sequence[Edit], second: Sequence[Edit]) -> list[Edit]:
    """Returns the edits of `source` that do what `first` does and then `second` to the result.

    Edits of both that touch each other become one. Insertions at one place keep their order.
    """
    between, written, grown = spliced(source, first), list[tuple[int, int]](), [0]
    for edit in in_order(first):
        start = edit.start + grown[-1]
        grown.append(grown[-1] + len(edit.text) - (edit.end - edit.start))
        written.append((start, edit.end + grown[-1]))
    ends = [end for _, end in written]

    def longer(at: int) -> int:
        """Returns by how many bytes the edited program is longer than its source, up to there."""
        return grown[bisect_right(ends, at)]

    edits, later = [], in_order(second)
    starts = [edit.start for edit in later]
    for low, high in _touching(written + [(edit.start, edit.end) for edit in second]):
        near = later[bisect_left(starts, low) : bisect_right(starts, high)]
        own = [Edit(e.start - low, e.end - low, e.text) for e in near if e.end <= high]
        text = spliced(between[low:high], own).decode("latin-1")
        edits.append(Edit(low - longer(low - 1), high - longer(high), text))
    return edits


def _touching(spans: Sequence[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Yields the spans that those become which overlap or meet."""
    low, high = -1, -1
    for start, end in sorted(spans):
        if low >= 0 and start > high:
            yield low, high
        low, high = (start, end) if low < 0 or start > high else (low, max(high, end))
    if low >= 0:
        yield low, high
