"""A field applied to a program, in streaming: read, displaced and written some lines at a time.

Memory does not grow with the program; only programs with loops, calls or contours by number are held whole, since
their blocks may run in any order, and those with corners and the like, which are written out first.
"""

import hashlib
import re
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Final, TypeAlias

import numpy as np

from trueloop._core import NcMapper, nc_survey
from trueloop.domain.option import MapOptions
from trueloop.domain.record import check_uncorrected, mark_of_field, record_id
from trueloop.errors import Code, Place, TrueloopError
from trueloop.nc.edit.changes import PLAIN_CORNER, SHAPE, TURNS, insert_heading
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.expand.block import gives_spline, motion_word
from trueloop.nc.expand.expand import WrittenOut, written_out
from trueloop.nc.field import Field
from trueloop.nc.program.called import tool_rows
from trueloop.nc.program.dialect import Dialect, dialect_named
from trueloop.nc.program.program import Program, Unit, contradicted, no_parameter, read_program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.nc.program.understood import errors_in, require_sound
from trueloop.nc.program.unit import unit_told

_SHAPING: Final = re.compile(
    rb",[ \t]*[RCA]|RND|CHF|CHR|ANG|A[RP]|RP|\bC[TP]|\bLP|CIP|[PI][AR][-+ \t\d]|A[ \t]*[-+\d.#]|[@^]", re.IGNORECASE
)
"""Pattern of blocks whose words may shape a move beside its end; it may match more."""


_POLAR: Final = ("LP", "CP")
"""Moves of Klartext to a radius and an angle about the pole."""

_SPLINE: Final = tuple(re.compile(letter + rb"[ \t]*0*5(?!\d)") for letter in (b"G", b"g"))
"""Splines of LinuxCNC, G5 to G5.2; they may match more. One that minds no case takes four times as long."""


def has_shapes(letters: Collection[str], dialect: Dialect) -> bool:
    """Returns whether words of these letters shape moves beside their ends."""
    shapes = SHAPE - {TURNS} | ({"A"} if dialect.line_angle else set())
    shapes |= PLAIN_CORNER if dialect.plain_corners else set()
    return bool(shapes & set(letters))


def written_out_file(
    program: Program, parameters: Mapping[str, float], *, skipped_blocks: bool, keeps_polar: bool
) -> tuple[Program, WrittenOut]:
    """Writes the whole program out and returns both. Raises what running it strictly does, and NC-EDIT.

    keeps_polar: LP and CP of Klartext keep their words: where every position has one displacement, CC has it too.
    """

    def run(program: Program) -> ToolPath:
        return program.run(
            parameters, skipped_blocks=skipped_blocks, roughing=False, placed=False, roughed_contours=True
        )

    path = run(program)
    require_sound(path)
    blocks = np.zeros(program.block_count, dtype=np.bool_)
    blocks[[program.core.block_at(found.start()) for found in _SHAPING.finditer(program.source)]] = True
    wordless = (path.word < 0).all(axis=1) | (path.motion == Motion.ARC)
    by_one = (path.word == np.roll(path.word, 1, axis=1)) & (path.word >= 0)  # one word sets two axes: it is polar
    drawn = blocks[path.block] | wordless | by_one.any(axis=1)
    if keeps_polar and program.dialect.klartext:
        words = ((block.index, motion_word(program, block)) for block in program.blocks)
        kept = np.zeros(program.block_count, dtype=np.bool_)
        kept[[index for index, word in words if word is not None and word.text.upper() in _POLAR]] = True
        drawn &= ~kept[path.block]
    done = written_out(program, path, np.flatnonzero(drawn).tolist(), run)
    if program.dialect.splines:
        with done.in_lines_of(program):
            # Refuses a spline that was not written out, as one without any length: its end would stay where it was
            for start in sorted(found.start() for code in _SPLINE for found in code.finditer(done.program.source)):
                block = done.program.block(done.program.core.block_at(start))
                if gives_spline(done.program, block):
                    text = done.program.source[block.start : block.end].decode("latin-1").strip()
                    raise Code.NC_EDIT.refusal(
                        f"{text[:60]!r} cannot be written out as explicit moves: it is not run, or goes nowhere",
                        hint="take the block out",
                        place=done.program.place(start),
                    )
    return program, done


LARGE = 1 << 16
"""So many bytes are read beside hashing and searching them; a thread costs more than it saves with fewer."""


_First: TypeAlias = tuple[int | None, int | None, int | None, int | None]
_Surveyed: TypeAlias = tuple[int, bool, tuple[bool, bool, bool], list[tuple[str, int]], _First, bool, int, str]
"""The result of `nc_survey` for some lines."""


@dataclass(frozen=True)
class Survey:
    """The survey of the whole program: which of X, Y, Z are named, the line of each letter's first word, the first
    lines that set an offset by G10, set the position register, and go to a place of the machine; whether words shape
    moves beside their ends; whether decimal commas are written; how many decimals coordinates have; the letters of
    rotary axes.
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
            try:
                check_uncorrected(lines)
            except TrueloopError as found:
                place = Place(line=line + (found.place.line or 1) - 1)
                raise found.code.refusal(found.message, hint=found.hint, place=place, values=found.values) from None
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
    sets_offset, sets_register, goes_to_machine, curve = first
    drawn = curve is not None or has_shapes(letters, dialect_named(dialect))
    return Survey(
        dialect=dialect,
        sha256=digest.hexdigest(),
        jumps=jumps,
        named=named,
        letters=letters,
        sets_offset=sets_offset,
        sets_register=sets_register,
        goes_to_machine=goes_to_machine,
        drawn=drawn,
        comma=comma,
        decimals=decimals,
        rotary=rotary,
    )


def _first(before: _First, blocks: _First, line: int) -> _First:
    def of(index: int) -> int | None:
        known, block = before[index], blocks[index]
        return line + block if known is None and block is not None else known

    return of(0), of(1), of(2), of(3)


def _any(left: tuple[bool, bool, bool], other: tuple[bool, bool, bool]) -> tuple[bool, bool, bool]:
    return (left[0] or other[0], left[1] or other[1], left[2] or other[2])


Pieces: TypeAlias = Callable[[], Iterable[bytes]]
"""A program in pieces of whole lines, from its beginning each time it is requested: it is read twice."""
HEAD: Final = 1 << 12
"""Bytes of a written program among which the lines are that have to be first."""


@dataclass(frozen=True)
class Mapped:
    """The result of mapping. `not_run` blocks have coordinates that stay as they were: skipped, or in a branch not
    taken.

    `called`: the files of programs that it calls, which are mapped with it. `notes`: what the correction leaves.
    `turns_back_line` is where a contour that is roughed as well does not run on any more; 0 where none does so.
    `unit`: the one in force at the first length, and what says so; see `trueloop.nc.program.unit`.
    """

    record: str
    dialect: str
    source_sha256: str
    blocks: int
    moves: int
    edits: int
    added_blocks: int
    largest_mm: tuple[float, float, float]
    not_run: int
    first_not_run_line: int
    unit: dict[str, str]
    turns_back_line: int = 0
    called: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def mapped_pieces(
    source: Pieces, dialect: str, field: Field, options: MapOptions, parameters: Mapping[str, float]
) -> Generator[bytes, None, Mapped]:
    """Yields the program, in pieces, with the field's displacement added to every position; returns the result at its
    end.

    Words keep their style, expressions get a term, increments carry the rounding on, and a move that the displaced
    path leaves by more than the tolerance becomes several. Rapid moves go straight to the displaced end. Touches, and
    positions in machine coordinates, stay; so does an axis until a position names it, since nobody knows where it
    stands. A comment says that the program is corrected and from what.

    Raises NC-UNIT, CMP-TWICE (corrected before), CMP-SIZE, CMP-SLOPE, NC-FIELD (not known at a
    position), NC-MAP (a block run several times at different places, a cut before every axis has a position or while a
    rotary axis stands turned, …), NC-OPAQUE (a cycle other than drilling) and what reading and running the program
    raise, some of it only with a later piece.
    """
    survey = survey_of(source(), dialect)
    for refusal in _not_followed(survey, field):
        raise refusal
    mapper = _mapper(field, survey, options, parameters)
    text = _text(source, survey, field, options, parameters)
    options_of_id = {"field": field.identity, "parameters": dict(parameters), **vars(options)}
    identity = record_id({"program": survey.sha256}, options_of_id)
    return _written(mapper, text, survey, _mark(identity, survey, parameters), identity, options.unit)


def obstacles(
    source: Pieces, dialect: str, field: Field, options: MapOptions, parameters: Mapping[str, float]
) -> list[TrueloopError]:
    """Returns everything for which `mapped_pieces` would refuse the program, in the order of its lines.

    After a block that is refused the next ones are looked at as if it had been displaced. Of a program that was
    corrected before that alone is returned. One whose shapes cannot be written out is looked at as it stands, apart
    from the blocks with shapes.
    """
    try:
        survey = survey_of(source(), dialect)
    except TrueloopError as corrected:
        return [corrected]
    found = list(_not_followed(survey, field))
    mapper = _mapper(field, survey, options, parameters)
    mapper.gather()
    shaped = set[int]()
    try:
        text = _text(source, survey, field, options, parameters)
    except TrueloopError as refused:
        program = read_program(b"".join(source()), dialect, None, options.unit)
        path = program.run(parameters, skipped_blocks=options.skipped_blocks, strict=False)
        found += [error.as_error() for error in errors_in(path)]
        if all((error.code, error.place.line) != (refused.code, refused.place.line) for error in found):
            found.append(refused)
        # As it stands it is looked at but for what would be written out, and what is an error already.
        text = _Text(source())
        shaped = {program.core.block_at(each.start()) + 1 for each in _SHAPING.finditer(program.source)}
        shaped |= {error.place.line for error in found if error.place.line}
    try:
        for _ in _displaced(mapper, text):
            pass
        obstructing = [_obstacle(text, *obstacle) for obstacle in mapper.obstacles()]
        found += [obstacle for obstacle in obstructing if obstacle.place.line not in shaped]
        _require_agreed(mapper, text, options.unit)
    except TrueloopError as refused:
        if refused.place.line not in shaped:
            found.append(refused)
    return _by_line(found)


def _by_line(errors: Iterable[TrueloopError]) -> list[TrueloopError]:
    return sorted(errors, key=lambda error: (error.place.line or 0, error.place.column or 0))


def _obstacle(text: "_Text", told: tuple[str, str, str, int, int], raised: BaseException | None) -> TrueloopError:
    if raised is not None and not isinstance(raised, TrueloopError):
        raise raised
    return _placed(raised or _refusal(told), text, *told[3:])


def _written(
    mapper: NcMapper, text: "_Text", survey: Survey, mark: str, identity: str, stated_unit: Unit | None
) -> Generator[bytes, None, Mapped]:
    written = filter(None, _displaced(mapper, text))
    yield _marked(next(written, b""), mark, survey.dialect)
    yield from written
    blocks, moves, edits, added, (x, y, z), not_run, first, turns_back, stated = mapper.summary()
    stated = stated and (text.line_of(stated[0]), stated[1])
    new = text.added_blocks
    edits += len(text.drawn[1].edits) if text.drawn else 0
    first = text.line_of(first) if not_run else first
    turns_back = text.line_of(turns_back) if turns_back else 0
    unit = unit_told(stated_unit, stated)
    dialect, sha256 = survey.dialect, survey.sha256
    done = Mapped(
        record=identity,
        dialect=dialect,
        source_sha256=sha256,
        blocks=blocks - new,
        moves=moves,
        edits=edits,
        added_blocks=added + new,
        largest_mm=(x, y, z),
        not_run=not_run,
        first_not_run_line=first,
        unit=unit,
        turns_back_line=turns_back,
    )
    _require_agreed(mapper, text, stated_unit)
    return done


def _not_followed(survey: Survey, field: Field) -> Iterator[TrueloopError]:
    """Yields what the whole program says against the field."""
    # o: an axis that Sinumerik calls by a letter and a number, A1.
    if field.follows and "o" in survey.letters:
        yield Code.NC_MAP.refusal(
            f"an axis with a number turns in this program, beside {' '.join(sorted(field.follows))} of the machine",
            hint="leave the word out, state with --at where the axis stands, and correct one program a position",
            place=Place(line=survey.letters["o"]),
        )
    if field.of_machine and survey.sets_offset is not None:
        yield Code.MCH_FRAME.refusal(
            f"line {survey.sets_offset} sets an offset, by G10 or a probe: where the zero lies then is not what the "
            "set-up says",
            hint="take the block out, give the offset with --work-zero, --tool or --offsets, and set it at the control",
            place=Place(line=survey.sets_offset),
        )
    if field.of_machine and field.tools is None and survey.sets_register and survey.goes_to_machine:
        yield Code.MCH_FRAME.refusal(
            f"the position register is set in line {survey.sets_register}, and line {survey.goes_to_machine} goes to a "
            "place of the machine: what that is called depends on the control's offset of the tool",
            hint="give the control's tables with --offsets",
            place=Place(line=survey.sets_register),
        )


def _mark(identity: str, survey: Survey, parameters: Mapping[str, float]) -> str:
    """Returns the comment of a corrected program, which states the values of parameters that it holds for."""
    given = ", ".join(f"{name}={value!r}" for name, value in sorted(parameters.items()))
    only = f", holds for {given} only" if given else ""
    return dialect_named(survey.dialect).comment(mark_of_field(identity, survey.sha256) + only)


def _mapper(field: Field, survey: Survey, options: MapOptions, parameters: Mapping[str, float]) -> NcMapper:
    try:
        return NcMapper(
            field.core,
            survey.dialect,
            list(parameters.items()),
            options.skipped_blocks,
            survey.jumps,
            survey.named,
            survey.comma,
            options.tolerance_mm,
            options.limit_mm,
            options.slope,
            tool_rows(field.tools or ()),
            list(field.work_mm.items()),
            None if options.unit is None else options.unit == "inch",
            survey.rotary,
            max(survey.decimals, options.decimals),
        )
    except ValueError as refused:
        raise no_parameter(str(refused), survey.dialect) from None


def _displaced(mapper: NcMapper, text: "_Text") -> Iterator[bytes]:
    try:
        for chunk in text.chunks:
            yield _accepted(mapper.push(chunk))
        yield _accepted(mapper.finish())
    except TrueloopError as error:
        raise _placed(error, text, *mapper.failed_at) from error


def _placed(error: TrueloopError, text: "_Text", line: int, column: int) -> TrueloopError:
    """Returns a refusal with its place in the program: that of the block where the field itself refused."""
    at = (line, column) if error.place.line is None else (error.place.line, error.place.column)
    place = Place(None, text.line_of(at[0]), None if text.drawn else at[1])
    return error.code.refusal(error.message, hint=error.hint, place=place, override=error.override, values=error.values)


@dataclass(frozen=True)
class _Text:
    """The text to map, in pieces: the program itself, or written out where it is `drawn` with less than every point."""

    chunks: Iterable[bytes]
    drawn: tuple[Program, WrittenOut] | None = None

    @property
    def added_blocks(self) -> int:
        """Returns the number of blocks that writing it out has added."""
        return self.drawn[1].program.block_count - self.drawn[0].block_count if self.drawn else 0

    def line_of(self, line: int) -> int:
        """Returns the line of the program from which a line of the text comes."""
        return self.drawn[1].source_line(self.drawn[0], line) if self.drawn else line


def _text(source: Pieces, survey: Survey, field: Field, options: MapOptions, values: Mapping[str, float]) -> _Text:
    if not survey.drawn:
        return _Text(source())
    program = read_program(b"".join(source()), survey.dialect, None, options.unit, options.decimals)
    skipped = options.skipped_blocks
    drawn = written_out_file(program, values, skipped_blocks=skipped, keeps_polar=field.is_shift)
    return _Text([drawn[1].program.source], drawn)


def _require_agreed(mapper: NcMapper, text: _Text, unit: Unit | None) -> None:
    *_, stated = mapper.summary()
    at = stated and (text.line_of(stated[0]) - 1, stated[1])
    for found in contradicted(unit, at, None):
        raise found.as_error()


def _accepted(done: tuple[bytes, tuple[str, str, str, int, int] | None]) -> bytes:
    written, refusal = done
    if refusal is not None:
        raise _refusal(refusal)
    return written


def _refusal(told: tuple[str, str, str, int, int]) -> TrueloopError:
    code, message, hint, line, column = told
    return Code(code).refusal(message, hint=hint, place=Place(None, line, column))


def marked(called: bytes, done: Mapped) -> bytes:
    """Returns a program that a mapped one calls with the mark of that."""
    comment = dialect_named(done.dialect).comment(mark_of_field(done.record, done.source_sha256))
    return _marked(called, comment, done.dialect)


def _marked(written: bytes, comment: str, dialect: str) -> bytes:
    """Returns the first piece of a written program with the mark behind the lines that have to be first."""
    end = written.find(b"\n", HEAD) + 1 or len(written)
    head = read_program(written[:end], dialect)
    return apply_edits(head, [insert_heading(head, [comment])]) + written[end:]
