"""Edits of an edited program as edits of its source."""

from collections.abc import Iterator, Sequence

from trueloop.nc.edit.edit import Edit, in_order, spliced


def composed(source: bytes, first: Sequence[Edit], second: Sequence[Edit]) -> list[Edit]:
    """Returns the edits of `source` that do what `first` does and then `second` to the result.

    Edits of both that touch each other become one. Insertions at one place keep their order.
    """
    between, written, grown = spliced(source, first), list[tuple[int, int, int]](), 0
    for edit in in_order(first):
        start = edit.start + grown
        grown += len(edit.text) - (edit.end - edit.start)
        written.append((start, edit.end + grown, grown))

    def longer(at: int) -> int:
        """By how much the edited program is longer than its source, up to there."""
        return next((by for _, end, by in reversed(written) if end <= at), 0)

    edits = []
    for low, high in _touching([span[:2] for span in written] + [(edit.start, edit.end) for edit in second]):
        own = [Edit(e.start - low, e.end - low, e.text) for e in second if low <= e.start and e.end <= high]
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
