"""One look at a whole program, some lines at a time, before it is displaced."""

import hashlib
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

from trueloop._core import nc_survey
from trueloop.domain.record import check_uncorrected
from trueloop.errors import Place, TrueloopError
from trueloop.loops.machine.drawn_program import has_shapes
from trueloop.nc.program.dialect import dialect_named

LARGE = 1 << 16
"""So many bytes are read beside hashing and searching them; a thread costs more than it saves with fewer."""


_First: TypeAlias = tuple[int | None, int | None, int | None, int | None]
_Surveyed: TypeAlias = tuple[int, bool, tuple[bool, bool, bool], list[tuple[str, int]], _First, bool, int, str]
"""What `nc_survey` finds in some lines."""


@dataclass(frozen=True)
class Survey:
    """What one look at the whole program finds: which of X, Y, Z are named, the line of each letter's first word, the
    first lines that set an offset by G10, set the position register, and go to a place of the machine; whether words
    shape moves beside their ends; whether decimal commas are written; how many decimals coordinates have; the letters
    of rotary axes.
    """

    dialect: str
    sha256: str
    jumps: bool
    named: tuple[bool, bool, bool]
    letters: Mapping[str, int]
    sets_offset: int | None
    sets_register: int | None
    goes_to_machine: int | None
    drawn: bool
    comma: bool
    decimals: int
    rotary: str


def survey_of(pieces: Iterable[bytes], dialect: str) -> Survey:
    """Looks through a program in pieces of whole lines. Raises CMP-TWICE where it was corrected before."""
    digest, jumps, named, comma, line = hashlib.sha256(), False, (False, False, False), False, 1
    decimals, rotary = 0, ""
    letters: dict[str, int] = {}
    first: _First = (None, None, None, None)
    with ThreadPoolExecutor(1) as beside:
        for lines in pieces:
            _require_uncorrected(lines, line)
            read: Callable[[], _Surveyed] = partial(nc_survey, lines, dialect)
            if len(lines) > LARGE:
                read = beside.submit(read).result
            digest.update(lines)
            blocks, jumps_here, named_here, letters_here, first_here, comma_here, decimals_here, rotary_here = read()
            decimals, rotary = max(decimals, decimals_here), "".join(sorted({*rotary, *rotary_here}))
            jumps, named, comma = jumps or jumps_here, _any(named, named_here), comma or comma_here
            for letter, block in letters_here:
                letters.setdefault(letter, line + block)
            first = _first(first, first_here, line)
            line += blocks
    *_, curve = first
    drawn = curve is not None or has_shapes(letters, dialect_named(dialect))
    return Survey(dialect, digest.hexdigest(), jumps, named, letters, *first[:3], drawn, comma, decimals, rotary)


def _first(before: _First, blocks: _First, line: int) -> _First:
    def of(index: int) -> int | None:
        known, block = before[index], blocks[index]
        return line + block if known is None and block is not None else known

    return of(0), of(1), of(2), of(3)


def _any(one: tuple[bool, bool, bool], other: tuple[bool, bool, bool]) -> tuple[bool, bool, bool]:
    return (one[0] or other[0], one[1] or other[1], one[2] or other[2])


def _require_uncorrected(lines: bytes, line: int) -> None:
    try:
        check_uncorrected(lines)
    except TrueloopError as found:
        place = Place(line=line + (found.place.line or 1) - 1)
        raise TrueloopError(found.code, found.message, hint=found.hint, place=place, values=found.values) from None
