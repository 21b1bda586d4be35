"""Edits of an edited program as edits of its source."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from trueloop.nc.edit.edit import Edit


@dataclass(frozen=True)
class _Written:
    """Bytes that the first step wrote, and those of the source that stood there."""

    start: int
    end: int
    source: tuple[int, int]


_Change = _Written | Edit


def composed(source: bytes, first: Sequence[Edit], second: Sequence[Edit]) -> list[Edit]:
    """Returns the edits of `source` that do what `first` does and then `second` to the result.

    Edits of both that touch each other become one. Insertions at one place keep their order.
    """
    written = list(_written(first))
    between = _between(source, first)
    changes: list[_Change] = sorted([*written, *second], key=lambda change: (change.start, change.end))
    return [_merged(between, written, cluster) for cluster in _touching(changes)]


def _in_order(edits: Sequence[Edit]) -> list[Edit]:
    return sorted(edits, key=lambda edit: (edit.start, edit.end))


def _written(edits: Sequence[Edit]) -> Iterator[_Written]:
    grown = 0
    for edit in _in_order(edits):
        start = edit.start + grown
        yield _Written(start, start + len(edit.text), (edit.start, edit.end))
        grown += len(edit.text) - (edit.end - edit.start)


def _between(source: bytes, edits: Sequence[Edit]) -> bytes:
    pieces, done = [], 0
    for edit in _in_order(edits):
        pieces += [source[done : edit.start], edit.text.encode("latin-1")]
        done = edit.end
    return b"".join([*pieces, source[done:]])


def _touching(changes: Sequence[_Change]) -> list[list[_Change]]:
    clusters: list[list[_Change]] = []
    for change in changes:
        if clusters and change.start <= max(other.end for other in clusters[-1]):
            clusters[-1].append(change)
        else:
            clusters.append([change])
    return clusters


def _merged(between: bytes, written: Sequence[_Written], cluster: Sequence[_Change]) -> Edit:
    low, high = cluster[0].start, max(change.end for change in cluster)
    text, done = "", low
    for edit in cluster:
        if isinstance(edit, Edit):
            text += between[done : edit.start].decode("latin-1") + edit.text
            done = edit.end
    text += between[done:high].decode("latin-1")
    own = [change for change in cluster if isinstance(change, _Written)]
    if own:
        return Edit(own[0].source[0] - own[0].start + low, own[-1].source[1] - own[-1].end + high, text)
    shift = next((change.source[1] - change.end for change in reversed(written) if change.end < low), 0)
    return Edit(low + shift, high + shift, text)
