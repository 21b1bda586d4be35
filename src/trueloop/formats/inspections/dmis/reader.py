"""DMIS result files: inspections of the parts and runs that a file reports."""

from collections import Counter
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
from trueloop.formats.inspections.dmis.settings import LENGTHS_MM, settings_from
from trueloop.formats.inspections.dmis.statements import dmis_text, statements_of
from trueloop.formats.inspections.dmis.values import characteristics_of, quantity_is_size, values_of
from trueloop.formats.inspections.dmis.words import Words, label_in, words_of
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Stated, Unit
from trueloop.formats.inspections.shared.text import HINT

SHOWN: Final = 5
"""How many names a remark repeats."""
LOOKED_AT: Final = 500
"""Statements of a file by which it is recognised."""


def _recognises(_path: Path, head: bytes) -> bool:
    """By its statements, in any encoding."""
    text = head.replace(b"\0", b"").decode("latin-1").removeprefix("ï»¿")
    statements = islice((one for one in statements_of(text) if one.text), LOOKED_AT)
    return any(_is_of_dmis(words) for one in statements if (words := words_of(one.text, one.line)) is not None)


def _is_of_dmis(words: Words) -> bool:
    if words.kind in ("F", "FA", "T", "TA"):
        return words.word in ("FEAT", "TOL")
    if words.word == "UNITS":
        return bool(words.fields) and words.fields[0].upper() in LENGTHS_MM
    output = words.word == "OUTPUT" and any(label_in(field) is not None for field in words.fields)
    return output or (words.word in ("DMISMN", "DMISMD", "FILNAM") and words.fields[:1] != ("",))


def read_dmis(path: Path, stated: Stated) -> MeasuredFile:
    """The inspections of a file. Raises MSR errors with the lines of what cannot be read."""
    with readable(path, Code.MSR_FILE, hint=HINT):
        content = path.read_bytes()
    return _read(content, path, stated)


def _read(content: bytes, path: Path, stated: Stated) -> MeasuredFile:
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
        characteristics.update({(one.feature, one.name): one for one in characteristics_of(run)})
    if not inspections:
        notes.say("it holds nothing measured that is read: no FA and no TA, as a program has none", 1)
    return MeasuredFile(path, "DMIS", encoding, unit, tuple(inspections), tuple(characteristics.values()), notes.all())


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


def _unit(statements: list[Words], stated: Stated) -> Unit | None:
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
    sizes = [one for one in values if isinstance(one, Reading) and quantity_is_size(one.quantity)]
    exact = Counter(one.actual == one.nominal for one in sizes)
    if len(sizes) > 1 and exact[True] == len(sizes):
        notes.say(
            f"all {len(sizes)} diameters and radii are exactly nominal: filled in, not measured?", sizes[0].line or 0
        )
