"""A field applied to a program, in streaming: read, displaced and written some lines at a time.

Memory does not grow with the program; only programs with loops, calls or contours by number are held whole, since
their blocks may run in any order.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop._core import NcMapper, nc_jumps
from trueloop.compensation.record import MARK, check_uncorrected, record_id
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.outputs import written_as_it_comes
from trueloop.nc.dialect import dialect_named
from trueloop.nc.field import Field
from trueloop.nc.guess import guess_dialect
from trueloop.nc.program import no_parameter

CHUNK: Final = 1 << 20
"""Bytes read at a time."""


@dataclass(frozen=True)
class MapOptions:
    """How a field is applied.

    tolerance_mm: how far the written path may leave the displaced one, rounding to the control's resolution not
    counted. limit_mm: largest displacement along an axis. slope: largest change of the displacement in a cut over its
    length, mm/mm. skipped_blocks: displace the blocks that start with a slash as well.
    """

    tolerance_mm: float = 0.0005
    limit_mm: float = 0.150
    slope: float = 0.040
    skipped_blocks: bool = False


@dataclass(frozen=True)
class Mapped:
    """What was done. `not_run` blocks have coordinates that stay as they were: skipped, or in a branch not taken."""

    record: str
    dialect: str
    blocks: int
    moves: int
    edits: int
    added_blocks: int
    largest_mm: tuple[float, float, float]
    not_run: int
    first_not_run_line: int


@dataclass(frozen=True)
class _Survey:
    """What one look at the whole file tells."""

    dialect: str
    sha256: str
    jumps: bool


def map_program(
    source: Path,
    target: Path,
    field: Field,
    options: MapOptions = MapOptions(),
    *,
    dialect: str | None = None,
    parameters: Mapping[str, float] | None = None,
) -> Mapped:
    """Writes `source` to `target` with the field's displacement added to every position.

    Words keep their style, expressions get a term, increments carry the rounding on, and a move that the displaced
    path leaves by more than the tolerance becomes several. Rapid moves go straight to the displaced end. Touches, and
    positions in machine coordinates, stay. A comment says that the program is corrected and from what.

    Raises NC-FILE, NC-DIALECT, CMP-TWICE (corrected before), CMP-SIZE, CMP-SLOPE, NC-FIELD (not known at a position),
    NC-MAP (a cycle, a block run several times at different places, …) and what reading and running the program raise;
    nothing is written then.
    """
    survey = _survey(source, dialect)
    if dialect_named(survey.dialect).formulas:
        raise TrueloopError(
            Code.NC_MAP,
            f"programs of the dialect {survey.dialect} are not mapped: frames and positions look alike",
            hint="have the program written for another control, map that",
            place=Place(str(source)),
        )
    mapper = _mapper(field, survey, options, parameters or {})
    identity = record_id({"program": survey.sha256}, {"field": field.told, **vars(options)})
    mark = dialect_named(survey.dialect).comment(f"{MARK} {identity} by a field, source {survey.sha256[:16]}")
    with written_as_it_comes(target, inputs=(source,)) as out:
        written = filter(None, _pieces(source, mapper, CHUNK))
        out.write(_marked(next(written, b""), mark))
        out.writelines(written)
    blocks, moves, edits, added, largest, not_run, first = mapper.summary()
    return Mapped(identity, survey.dialect, blocks, moves, edits, added, largest, not_run, first)


def _mapper(field: Field, survey: _Survey, options: MapOptions, parameters: Mapping[str, float]) -> NcMapper:
    try:
        return NcMapper(
            field.core,
            survey.dialect,
            list(parameters.items()),
            options.skipped_blocks,
            survey.jumps,
            options.tolerance_mm,
            options.limit_mm,
            options.slope,
        )
    except ValueError as refused:
        raise no_parameter(str(refused), survey.dialect) from None


def _pieces(source: Path, mapper: NcMapper, size: int) -> Iterator[bytes]:
    for chunk in _chunks(source, size):
        yield _accepted(source, mapper.push(chunk))
    yield _accepted(source, mapper.finish())


def _accepted(source: Path, done: tuple[bytes, tuple[str, str, str, int, int] | None]) -> bytes:
    written, refusal = done
    if refusal is not None:
        code, message, hint, line, column = refusal
        raise TrueloopError(Code(code), message, hint=hint, place=Place(str(source), line, column))
    return written


def _chunks(path: Path, size: int) -> Iterator[bytes]:
    try:
        with path.open("rb") as file:
            while chunk := file.read(size):
                yield chunk
    except OSError as error:
        raise TrueloopError(
            Code.NC_FILE,
            f"{str(path)!r} cannot be read: {error.strerror or error}",
            hint="name an NC program",
            place=Place(str(path)),
        ) from error


def _survey(path: Path, dialect: str | None) -> _Survey:
    """Hash, dialect, whether it jumps; refuses a program that was corrected before."""
    digest, jumps, line = hashlib.sha256(), False, 0
    for lines in _whole_lines(path):
        digest.update(lines)
        dialect = dialect_named(dialect or guess_dialect(lines, str(path))).name
        jumps = jumps or nc_jumps(lines, dialect)
        _require_uncorrected(path, lines, line)
        line += lines.count(b"\n")
    return _Survey(dialect or guess_dialect(b"", str(path)), digest.hexdigest(), jumps)


def _whole_lines(path: Path) -> Iterator[bytes]:
    waiting = b""
    for chunk in _chunks(path, CHUNK):
        lines, newline, waiting = (waiting + chunk).rpartition(b"\n")
        if newline:
            yield lines + newline
    if waiting:
        yield waiting


def _require_uncorrected(path: Path, lines: bytes, lines_before: int) -> None:
    try:
        check_uncorrected(lines)
    except TrueloopError as found:
        place = Place(str(path), lines_before + (found.place.line or 1))
        raise TrueloopError(found.code, found.message, hint=found.hint, place=place) from None


def _marked(source: bytes, comment: str) -> bytes:
    """The mark on a line of its own: after a leading % line, else first."""
    at = source.find(b"\n") + 1 if source.lstrip().startswith(b"%") else 0
    ending = b"\r\n" if b"\r\n" in source else b"\n"
    return source[:at] + comment.encode("latin-1") + ending + source[at:]
