"""Reads DMIS result files: inspections of the parts and runs that a file reports.

A line is one statement. `$` at its end continues it, even inside a word; `$$` begins a comment; a comma before `$$`
continues it too, and so does a line that begins with what begins no statement (a comma, a number). All of it was seen
in files of measuring software; blanks at the beginning of a continued line are not part of it, outside of quoted text.
"""

import io
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Final

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code
from trueloop.formats.input_file import readable
from trueloop.formats.inspections.dmis.interpret import Interpreter, announced_in
from trueloop.formats.inspections.dmis.runs import Notes, Run
from trueloop.formats.inspections.dmis.values import characteristics_of, quantity_is_size, values_of
from trueloop.formats.inspections.dmis.words import LENGTHS_MM, Words, label_in, settings_from, words_of
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, StatedFacts, Unit
from trueloop.formats.inspections.shared.text import HINT, decoded

BLANKS: Final = " \t\f\v\x1a\0\ufeff"
"""No part of a statement at a line's ends; ^Z ends files of old systems, the last is a byte order mark."""
STRIPPED: Final = BLANKS + "\r\n"
BEGINS: Final = re.compile(r"\s*(?:[A-Za-z]+\s*\(.*?\)\s*=|[A-Za-z]+\s*/|(?:DATE|TIME)\s*=|[A-Za-z]{6}\s*$)", re.I)
"""The pattern of a line that does not continue another."""
QUOTE_OR_COMMENT: Final = re.compile(r"'|\$\$")


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement or, with empty `text`, one comment or blank line.

    `text` is without comments and line ends, `raw` as it stands in the file over one or more lines, the first `line`.
    """

    text: str
    line: int
    raw: str


def dmis_text(content: bytes, path: Path) -> tuple[str, str]:
    """Returns a file's text and an encoding that gives its bytes again: Latin-1 where no likelier one does."""
    _, encoding = decoded(content, path)
    encoding = {"utf-8-sig": "utf-8", "utf-16": "utf-16-be" if content[:1] == b"\xfe" else "utf-16-le"}.get(
        encoding, encoding
    )
    try:
        text = content.decode(encoding)
        if text.encode(encoding) == content:
            return text, encoding
    except UnicodeError:
        pass
    return content.decode("latin-1"), "latin-1"


def statements_of(text: str) -> Iterator[Statement]:
    """Yields the statements of a text, in its order; their `raw` put together is the text."""
    pieces: list[str] = []
    raws: list[str] = []
    first, state = 1, _CLOSED
    for number, raw in enumerate(io.StringIO(text, newline=""), 1):
        plain = state is _CLOSED and raw[:1].isalpha()  # begins a statement
        if raws and (plain or not _continues(state, raw, any(pieces))):
            yield Statement(_joined(pieces), first, "".join(raws))
            pieces, raws, state = [], [], _CLOSED
        if not raws:
            first = number
        raws.append(raw)
        if plain and "$" not in raw:
            pieces.append(raw)
            continue
        body = raw.rstrip("\r\n")
        if state is _COMMENT:
            state = _COMMENT if _cut(body) else _CLOSED
            continue
        piece, state = _piece(body, quoted=state is _QUOTED, begun=bool(pieces))
        pieces.append(piece)
    if raws:
        yield Statement(_joined(pieces), first, "".join(raws))


_CLOSED, _CUT, _QUOTED, _COMMA, _COMMENT = "closed", "cut", "cut inside a quoted text", "after a comma", "comment cut"
"""How a line leaves its statement: complete, to be continued in one of three ways, or a comment that goes on."""


def _joined(pieces: list[str]) -> str:
    """The text of a statement; a piece may have its line's end still."""
    if len(pieces) > 1:
        return "".join([piece.rstrip("\r\n") for piece in pieces]).strip(BLANKS)
    return pieces[0].strip(STRIPPED) if pieces else ""


def _continues(state: str, body: str, begun: bool) -> bool:
    """Returns whether a line belongs to the statement or, where none has begun, to the comment before it."""
    if state in (_CUT, _QUOTED):
        return True
    if state in (_COMMA, _COMMENT):
        return not BEGINS.match(body)
    begin = body.lstrip(BLANKS)[:1]
    return begun and begin != "" and begin in ",+-.0123456789"


def _piece(body: str, *, quoted: bool, begun: bool) -> tuple[str, str]:
    """Returns the text that a line adds to its statement, and the state after it. A comment line within a statement
    adds nothing.
    """
    text = body if quoted else body.lstrip(BLANKS)
    if "$" not in text:
        return text, _CLOSED
    comment = _comment_at(text, quoted)
    if comment == 0:
        return "", _COMMA if begun else _COMMENT if _cut(text) else _CLOSED
    if comment > 0:
        text = text[:comment].rstrip(BLANKS)
        return text, _COMMA if text.endswith(",") else _CLOSED
    if not _cut(text):
        return text, _CLOSED
    text = text.rstrip(BLANKS)[:-1]
    return text, _QUOTED if (text.count("'") + quoted) % 2 else _CUT


def _cut(body: str) -> bool:
    """Returns whether a line ends with one `$`."""
    end = body.rstrip(BLANKS)
    return end.endswith("$") and not end.endswith("$$")


def _comment_at(text: str, quoted: bool) -> int:
    """Where a comment begins outside of quoted text; -1 where none does."""
    if "'" not in text:
        return -1 if quoted else text.find("$$")
    for found in QUOTE_OR_COMMENT.finditer(text):
        if found[0] == "'":
            quoted = not quoted
        elif not quoted:
            return found.start()
    return -1


SHOWN: Final = 5
"""The number of names that a remark repeats."""
LOOKED_AT: Final = 500
"""Statements of a file by which it is recognised."""


def _recognises(_path: Path, head: bytes) -> bool:
    """By its statements, in any encoding."""
    text = head.replace(b"\0", b"").decode("latin-1").removeprefix("ï»¿")
    statements = islice((statement for statement in statements_of(text) if statement.text), LOOKED_AT)
    return any(
        _is_of_dmis(words)
        for statement in statements
        if (words := words_of(statement.text, statement.line)) is not None
    )


def _is_of_dmis(words: Words) -> bool:
    if words.kind in ("F", "FA", "T", "TA"):
        return words.word in ("FEAT", "TOL")
    if words.word == "UNITS":
        return bool(words.fields) and words.fields[0].upper() in LENGTHS_MM
    output = words.word == "OUTPUT" and any(label_in(field) is not None for field in words.fields)
    return output or (words.word in ("DMISMN", "DMISMD", "FILNAM") and words.fields[:1] != ("",))


def read_dmis(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads the inspections of a file. Raises MSR errors with the lines of what cannot be read."""
    with readable(path, Code.MSR_FILE, hint=HINT):
        content = path.read_bytes()
    return _read(content, path, stated)


def _read(content: bytes, path: Path, stated: StatedFacts) -> MeasuredFile:
    text, encoding = dmis_text(content, path)
    notes = Notes()
    statements = _statements(text, notes)
    at = Interpreter(settings_from(path, stated), announced_in(statements), notes=notes)
    unit = _unit(statements, stated)
    for statement in statements:
        at.carry_out(statement)
    runs = at.finish()
    sha256 = sha256_of(content)
    inspections, characteristics = [], dict[tuple[str, str], Characteristic]()
    for number, run in enumerate(runs, 1):
        values = values_of(run, notes, at.announced.written)
        _remark_missing(run, notes, f" of run {number}" if len(runs) > 1 else "")
        _remark_filled_in(values, notes)
        if values:
            inspections.append(_inspection(run, values, sha256, path))
        characteristics.update(
            {
                (characteristic.feature, characteristic.name): characteristic
                for characteristic in characteristics_of(run)
            }
        )
    if not inspections:
        notes.say("it holds nothing measured that is read: no FA and no TA, as a program has none", 1)
    return MeasuredFile(
        path=path,
        format="DMIS",
        encoding=encoding,
        unit=unit,
        inspections=tuple(inspections),
        characteristics=tuple(characteristics.values()),
        remarks=notes.all(),
    )


FORMAT: Final = Format("DMIS", _recognises, read_dmis)


def _statements(text: str, notes: Notes) -> list[Words]:
    found = []
    for statement in statements_of(text):
        if statement.text:
            words = words_of(statement.text, statement.line)
            if words is None:
                notes.count("a line that is no statement was left out", statement.line)
            else:
                found.append(words)
    return found


def _unit(statements: list[Words], stated: StatedFacts) -> Unit | None:
    """The file's first unit; that of the user where it states none."""
    for statement in statements:
        if statement.word == "UNITS":
            words = {field.upper() for field in statement.fields}
            return "mm" if "MM" in words else "inch" if "INCH" in words else None
    return stated.unit


def _inspection(run: Run, values: tuple[Reading | CmmPoint, ...], sha256: str, path: Path) -> Inspection:
    heading = run.heading
    name = heading.part or Path(heading.file.replace("\\", "/")).stem or path.stem
    kinds = {type(value) for value in values}
    return Inspection(
        part=Part(PartType(name, heading.revision), heading.serial),
        measured="CMM points"
        if kinds == {CmmPoint}
        else "readings"
        if kinds == {Reading}
        else "readings and CMM points",
        sha256=sha256,
        count=len(values),
        values=values,
        device=heading.device,
        operator=heading.operator,
        frame=run.frame,
        measured_at=heading.moment,
    )


def _remark_missing(run: Run, notes: Notes, where: str) -> None:
    """Features that the run names and did not measure; where it names none, of those that an earlier one has named."""
    asked, measured = (
        {mark.removeprefix(kind) for mark in run.stated if mark.startswith(kind)} for kind in ("F ", "FA ")
    )
    if not asked and measured & set(run.nominals):
        asked = set(run.nominals)
    without = asked - measured
    missing = [feature for key, feature in run.nominals.items() if key in without]
    if missing:
        names = ", ".join(repr(feature.label) for feature in missing[:SHOWN])
        more = f" and {len(missing) - SHOWN} more" if len(missing) > SHOWN else ""
        verb = "has" if len(missing) == 1 else "have"
        notes.say(f"{len(missing)} of {len(asked)} features{where} {verb} no actual: {names}{more}", missing[0].line)


def _remark_filled_in(values: tuple[Reading | CmmPoint, ...], notes: Notes) -> None:
    """Sizes that are all nominal to the last decimal were not measured but filled in."""
    sizes = [value for value in values if isinstance(value, Reading) and quantity_is_size(value.quantity)]
    exact = Counter(size.actual == size.nominal for size in sizes)
    if len(sizes) > 1 and exact[True] == len(sizes):
        notes.say(
            f"all {len(sizes)} diameters and radii are exactly nominal: filled in, not measured?", sizes[0].line or 0
        )
