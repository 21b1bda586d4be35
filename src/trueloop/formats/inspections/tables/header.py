"""The row of a table that names its columns: the one whose cells are known headings with numbers under them."""

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.formats.inspections.shared.text import NUMBER, is_empty
from trueloop.formats.inspections.tables.grid import SAMPLE, Row
from trueloop.formats.inspections.tables.headings import (
    ENDS,
    IN_DOUBT,
    KNOWN,
    LENGTHS,
    PARTNERS,
    Role,
    of_quantity,
    plain,
    unit_named,
    without_unit,
)

BELOW: Final = 12
"""Rows under a heading that are looked at."""
PREFIXED: Final = re.compile(rf"(?:[ØøR⌀∅±n]\s*)?(?:{NUMBER.pattern})(?:\s*(?:mm|in|inch|µm|μm|°|\"))?")
LEAST: Final = 1.6
"""Score that a row of headings has at least: a length and one more, or a serial number and columns of numbers."""
BEGINS: Final = re.compile(r"[ØøR⌀∅±n]?\s*[-+−]?[.,]?\d")


@dataclass(frozen=True)
class Header:
    """The headings: `row` of the last of `rows` rows of them, from 0; unique names, and their plain forms by column.

    `quantities` are those that headings name beside a value, as `Ø Ist`, of which `plain` has the rest, or alone.
    """

    row: int
    rows: int
    names: tuple[str, ...]
    plain: tuple[str, ...]
    quantities: tuple[Quantity | None, ...]
    score: float

    @property
    def title(self) -> int:
        """Returns the number of rows above it."""
        return self.row - self.rows + 1


def find_header(rows: Sequence[Row]) -> Header | None:
    """Returns the row with the best score, the first of equal ones; None where none is a heading."""
    found = [header for row in range(min(len(rows), SAMPLE)) for header in _candidates(rows, row)]
    best = max(found, key=lambda header: header.score, default=None)
    return best if best is not None and best.score >= LEAST else None


def score(rows: Sequence[Row]) -> float:
    """Returns the best row's score as headings; 0 without one."""
    header = find_header(rows)
    return 0.0 if header is None else header.score


def header_at(rows: Sequence[Row], row: int, count: int) -> Header:
    """Returns the headings in that row and, of two rows of them, the one above."""
    below = list(rows[row])
    above = list(rows[row - 1]) if count == 2 and row else []
    above += [""] * (len(below) - len(above))
    titles = itertools.accumulate(above, _latest)  # a title over several columns stands in the first
    texts = [_together(title, low) or high for high, title, low in zip(above, titles, below, strict=False)]
    plains, quantities = zip(*(of_quantity(plain(without_unit(text))) for text in texts), strict=True)
    return Header(
        row=row,
        rows=count,
        names=_unique(texts),
        plain=plains,
        quantities=quantities,
        score=_score(rows[row + 1 : row + 1 + BELOW], texts, plains, quantities),
    )


def number_like(cell: str) -> bool:
    """Returns whether a cell is a number, with or without a symbol before it or a unit after it."""
    return PREFIXED.fullmatch(cell.replace("−", "-")) is not None


def begins_as_number(cell: str) -> bool:
    """Returns whether a cell is meant as a number: also one that cannot be read."""
    return BEGINS.match(cell) is not None


def known(name: str) -> bool:
    """Returns whether a plain heading has a meaning."""
    return name in KNOWN or name in ENDS or name in IN_DOUBT or name in PARTNERS


def _candidates(rows: Sequence[Row], row: int) -> list[Header]:
    texts = [cell for cell in rows[row] if cell]
    if len(texts) < 2 or sum(map(number_like, texts)) * 2 > len(texts):
        return []
    one = header_at(rows, row, 1)
    two = header_at(rows, row, 2) if row and any(rows[row - 1]) else one
    return [two] if two.score > one.score else [one]


def _latest(last: str, cell: str) -> str:
    return cell or last


def _together(title: str, below: str) -> str:
    """The heading below, with the title above where only both together are known."""
    both = f"{title} {below}"
    if not below or plain(without_unit(below)) in KNOWN or plain(without_unit(both)) not in KNOWN:
        return below
    return both


def _unique(texts: Sequence[str]) -> tuple[str, ...]:
    seen: dict[str, int] = {}
    out = []
    for place, text in enumerate(texts, 1):
        name = " ".join(text.split()) or f"#{place}"
        seen[name] = seen.get(name, 0) + 1
        out.append(name if seen[name] == 1 else f"{name}#{seen[name]}")
    return tuple(out)


def _score(
    below: Sequence[Row], texts: Sequence[str], plains: Sequence[str], quantities: Sequence[Quantity | None]
) -> float:
    """2 for a length with numbers under it, 1 for other things, a third for unknown columns of numbers."""
    counted: dict[str, float] = {}
    filled = sum(map(any, below))
    for column, name in enumerate(plains):
        if not name or unit_named(texts[column]):
            continue
        cells = [row[column] for row in below if column < len(row) and not is_empty(row[column])]
        numbers = not filled or sum(map(number_like, cells)) * 2 > len(cells)
        role = KNOWN[name][0] if name in KNOWN else None
        if role in LENGTHS or (role is None and known(name)):
            counted[name] = 2.0 if numbers else 0.4
        elif role is not None:
            counted[role] = 1.0 if 2 * len(cells) >= filled else 0.2
        elif numbers and cells and quantities[column] is not None:
            counted[name] = 1.0
        elif numbers and cells:
            counted[f" {column}"] = 1 / 6 if number_like(texts[column]) else 1 / 3
    return sum(counted.values())


def is_unit_row(row: Row) -> bool:
    """Returns whether a row under the headings has units, two or more, and nothing else."""
    cells = [cell for cell in row if not is_empty(cell)]
    return len(cells) > 1 and all(unit_named(cell) for cell in cells)


NUMBERED: Final = re.compile(r"(.*?)\s*(\d+)")


def numbered(name: str) -> str | None:
    """Returns the plain heading without the number it ends with; None where it ends with none."""
    found = NUMBERED.fullmatch(name)
    return found[1] if found else None


def role_of(name: str, names: Sequence[str]) -> tuple[Role, int] | None:
    """Returns role and rank of a plain heading among all of a table; None: unknown, or an end that values decide."""
    if name in IN_DOUBT:
        found = {role for partner, role in IN_DOUBT[name].items() if partner in names}
        return (found.pop(), 0) if len(found) == 1 else None
    return (PARTNERS[name], 0) if name in PARTNERS else KNOWN.get(name)


def stated_above(rows: Sequence[Sequence[str]]) -> Iterator[tuple[Role, str, str]]:
    """Yields the role, the plain name and the text of each `Operator: Meier`, in one cell or in two."""
    for row in rows:
        cells = [cell for cell in row if not is_empty(cell)]
        for cell, after in itertools.pairwise([*cells, ""]):
            name, _, value = cell.partition(":")
            role = KNOWN.get(plain(name), (None, 0))[0]
            if role is not None and (text := value.strip() or after):
                yield role, plain(name), text
