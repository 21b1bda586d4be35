"""The statements of a DMIS file carried out one after the other: what is in force, and what is said under it."""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.dmis.features import WORDS, Feature, feature_of
from trueloop.formats.inspections.dmis.runs import (
    BETWEEN,
    Actual,
    Heading,
    Notes,
    Result,
    Run,
    RunResult,
    Tolerance,
    result_of,
    shared,
    tolerance_of,
    with_date,
    with_time,
)
from trueloop.formats.inspections.dmis.words import (
    FIRST,
    PLANES,
    Frame,
    Settings,
    Words,
    degrees_of,
    is_number,
    key_of,
    label_in,
    number_of,
    unquoted,
    with_units,
)

ORIGINS: Final = {"XORIG": 0, "YORIG": 1, "ZORIG": 2}
TURNED_ABOUT: Final = {"XAXIS": 0, "YAXIS": 1, "ZAXIS": 2}


def moved(
    statement: Words, settings: Settings, frames: Mapping[str, Frame], datums: str, *, measured: bool
) -> tuple[str, Frame | None]:
    """Returns datums and frame in force after a statement; the frame is None where it begins anew at other datums.

    `D(…)=TRANS/XORIG,10` puts the origin at x = 10, `D(…)=ROTATE/ZAXIS,30` turns the axes by 30° from x to y (both from
    memory of DMIS 5.2). Before anything was measured every statement is taken as the set-up of the part. Raises
    MSR-FRAME for a change after measured features that the file does not give in numbers.
    """
    if not measured:
        return datums or _text(statement), None
    if statement.word == "DATSET":
        if datums:
            if datums == _text(statement):
                return datums, settings.frame
            raise _refusal(statement, settings)
        return _text(statement), None
    if statement.word == "TRANS":
        return datums, _shifted(statement, settings)
    if statement.word == "ROTATE":
        return datums, _turned(statement, settings)
    label = label_in(statement.fields[0]) if statement.fields else None
    frame = frames.get(key_of(label[1])) if label is not None else None
    if frame is None:
        raise _refusal(statement, settings)
    return datums, frame


def _shifted(statement: Words, settings: Settings) -> Frame:
    shift = [0.0, 0.0, 0.0]
    fields = statement.fields
    for name, text in zip(fields[::2], fields[1::2], strict=False):
        if name.upper() not in ORIGINS or not is_number(text):
            raise _refusal(statement, settings)
        value = number_of(text, settings, statement.line) or 0.0
        shift[ORIGINS[name.upper()]] = value * settings.length_factor(statement.line)
    if len(fields) % 2 or not fields:
        raise _refusal(statement, settings)
    return settings.frame.shifted((shift[0], shift[1], shift[2]))


def _turned(statement: Words, settings: Settings) -> Frame:
    fields = statement.fields
    if len(fields) != 2 or fields[0].upper() not in TURNED_ABOUT or not is_number(fields[1]):
        raise _refusal(statement, settings)
    angle_deg = degrees_of(fields[1], settings, statement.line) or 0.0
    return settings.frame.turned(TURNED_ABOUT[fields[0].upper()], angle_deg)


def _text(statement: Words) -> str:
    return ",".join(statement.fields).upper()


def _refusal(statement: Words, settings: Settings) -> TrueloopError:
    text = f"{statement.word}/{','.join(statement.fields)}"
    return Code.MSR_FRAME.refusal(
        f"{text!r} changes the coordinate system between measured features, and its size is not in the file",
        hint="report all features of a part in one coordinate system, or each system in a file of its own",
        place=Place(str(settings.path), statement.line),
        values={"statement": text},
    )


# fmt: off
NO_RESULT: Final = frozenset((
    "ACLRAT", "ALGDEF", "ASSIGN", "BADTST", "BOUND", "CALIB", "CALL", "CALLM", "CASE", "CLMPID", "CLMPSN", "CLOSE",
    "CONST", "CROSCL", "CUSTID", "CUTCOM", "DATDEF", "DECL", "DECPL", "DELETE", "DEVICE", "DFTCAS", "DISPLY",
    "DMEHW", "DMESW", "DMESWI", "DMESWV", "DMIS", "DMISMD", "DO", "ELSE", "ENDAT", "ENDCAS", "ENDDO", "ENDGO",
    "ENDIF", "ENDMAC", "ENDMES", "ENDSEL", "ENDSIM", "ENDXTN", "EQUATE", "ERROR", "EVAL", "EXTENS", "EXTFIL",
    "FEATUR", "FEDRAT", "FINPOS", "FIXTID", "FIXTSN", "FLY", "FROM", "GEOALG", "GEOM", "GOHOME", "GOTARG", "GOTO",
    "HOME", "IF", "INCLUD", "ITERAT", "JUMPTO", "KEYCHR", "LITDEF", "LOCATE", "LOTID", "MACRO", "MATDEF", "MEAS",
    "MFGDEV", "MODE", "NOTOL", "OBTAIN", "OPEN", "PAMEAS", "PATH", "PAUSE", "PLANID", "POP", "PRCOMP", "PREVOP",
    "PROCID", "PROMPT", "PSTHRU", "PTBUFF", "PTMEAS", "PUSH", "RAPID", "READ", "REFMNT", "REPORT", "RESUME",
    "RMEAS", "ROTAB", "ROTDEF", "ROTHDF", "ROTSET", "SAVE", "SCAN", "SCNMOD", "SCNPLN", "SCNSET", "SELECT",
    "SENSOR", "SIMREQT", "SNSDEF", "SNSET", "SNSGRP", "SNSLCT", "SNSMNT", "TECOMP", "TEMPR", "TEXT", "THLDEF",
    "TOLSET", "TOOLDF", "UNCERT", "VALUE", "VFORM", "WINDEF", "WRIST", "WRITE", "XTERN", "XTRACT", "ZLABEL",
))
# fmt: on
"""From memory of DMIS 5.2 and programs seen."""


DATE: Final = re.compile(r"'?(\d{4})[/.-](\d{1,2})[/.-](\d{1,2})'?")
TIME: Final = re.compile(r"'?(\d{1,2}):(\d{1,2})(?::(\d{1,2})(?:\.\d*)?)?'?")
NAMES: Final = {
    "PARTID": "part", "PARTSN": "serial", "PARTRV": "revision", "DMEID": "device", "OPERID": "operator",
    "PN": "part", "PS": "serial", "PR": "revision", "DI": "device", "OP": "operator",
}  # fmt: skip
"""Meanings of labelled texts of the heading, by their word, else by the kind of their label."""
NEW_PART: Final = ("file", "part", "serial")
OUTPUTS: Final = ("OUTPUT", "RPTOUT")


@dataclass(frozen=True)
class Announced:
    """Announcements of a file's outputs: `lines` the features and the tolerances' labels of each, by its line.

    By the label of a tolerance, `features` all that it is output with, in their order, and `by` these output by output.
    `written`: how features' labels are written at first.
    """

    lines: dict[int, tuple[tuple[str, ...], frozenset[str]]]
    features: dict[str, dict[str, None]]
    by: dict[str, set[tuple[str, ...]]]
    written: dict[str, str]


@dataclass
class Interpreter:
    """A file while it is read: `runs` are those finished, `notes` what has to be said about it."""

    settings: Settings
    announced: Announced
    run: Run = field(default_factory=lambda: Run(Heading()))
    runs: list[Run] = field(default_factory=list)
    notes: Notes = field(default_factory=Notes)
    frames: dict[str, Frame] = field(default_factory=dict)
    datums: str = ""
    heading: Heading = field(default_factory=Heading)
    output: tuple[str, ...] = ()
    names: frozenset[str] = frozenset()
    held: Run | None = None
    last: str = ""

    def carry_out(self, statement: Words) -> None:
        """Carries out one statement. Raises MSR errors with its line."""
        by_kind = BY_KIND.get(statement.kind) if statement.word in ("FEAT", "TOL") else None
        if (do := by_kind or BY_WORD.get(statement.word)) is not None:
            do(self, statement)
        elif statement.word in NAMES or (statement.kind in NAMES and not statement.word):
            _name(self, statement)
        elif statement.word not in NO_RESULT:
            self.notes.count(f"{_title(statement)} is not understood and was left out", statement.line)

    def begin(self, *, sure: bool) -> None:
        """Begins a new run at a heading where something was measured; provisionally, unless it is `sure`."""
        if self.run.measured:
            self._join()
            self.held, self.run = self.run, self.run.next(self.heading)
            self.output, self.names = (), frozenset()
        if sure:
            self._part()
        self.run.heading = self.heading

    def state(self, mark: str, feature: str) -> None:
        """Takes a feature's statement. Where the run that is held has it too, they are two runs."""
        if self.held is not None and mark in self.held.stated:
            self._part()
        self.run.stated.add(mark)
        if feature not in self.output:
            self.output, self.names = (feature,), frozenset()

    def _part(self) -> None:
        if self.held is not None:
            self.runs.append(self.held)
        self.held = None

    def _join(self) -> None:
        if self.held is not None:
            self.run = self.held.joined(self.run)
        self.held = None

    def apart(self) -> None:
        """Ends the run, whatever follows."""
        self._join()
        self.runs.append(self.run)
        self.run = self.run.next(self.heading)

    def finish(self) -> list[Run]:
        """Returns all runs in which something was measured, or else one without."""
        self._join()
        runs = [*self.runs, self.run]
        return [run for run in runs if run.measured] or runs[-1:]

    def limited(self, label: str) -> tuple[str, ...]:
        """Returns the features of a tolerance: all that are output with its label, else those of this output."""
        return tuple(self.announced.features.get(key_of(label), ())) or self.output

    def about(self, label: str) -> tuple[str, ...]:
        """Returns the features of a result: those of this output, unless its label is announced by one other alone."""
        key = key_of(label)
        outputs = self.announced.by.get(key, set())
        return next(iter(outputs)) if key not in self.names and len(outputs) == 1 else self.output


def announced_in(statements: Iterable[Words]) -> Announced:
    """Returns the announcements of a file's outputs."""
    lines = dict[int, tuple[tuple[str, ...], frozenset[str]]]()
    features, by, written = dict[str, dict[str, None]](), dict[str, set[tuple[str, ...]]](), dict[str, str]()
    for statement in statements:
        if statement.word in OUTPUTS:
            output, names = lines[statement.line] = _announced(statement, written)
            for name in names:
                features.setdefault(name, {}).update(dict.fromkeys(output))
                by.setdefault(name, set()).add(output)
    return Announced(lines, features, by, written)


def _announced(statement: Words, written: dict[str, str]) -> tuple[tuple[str, ...], frozenset[str]]:
    features, names = [], []
    for text in statement.fields:
        label = label_in(text)
        if label is not None and label[0] in ("F", "FA"):
            key = key_of(label[1])
            written.setdefault(key, label[1])
            features.append(key)
        elif label is not None and label[0] in ("T", "TA"):
            names.append(key_of(label[1]))
    return tuple(features), frozenset(names)


def _title(statement: Words) -> str:
    detail = f"/{statement.fields[0]}" if statement.word in ("FEAT", "TOL") and statement.fields else ""
    return f"{statement.kind}(…)={statement.word}{detail}" if statement.kind else f"{statement.word}{detail}"


def _output(at: Interpreter, statement: Words) -> None:
    at.output, at.names = at.announced.lines[statement.line]


def _nominal(at: Interpreter, statement: Words) -> None:
    key = key_of(statement.label)
    at.state(f"F {key}", key)
    feature = _stated(at, statement, lambda: feature_of(statement, at.settings))
    if isinstance(feature, Feature):
        at.run.nominals[key] = feature
    elif isinstance(feature, str):
        at.notes.count(f"{_title(statement)} {feature}", statement.line)


def _actual(at: Interpreter, statement: Words) -> None:
    key = key_of(statement.label)
    at.state(f"FA {key}", key)
    feature = feature_of(statement, at.settings)
    if not isinstance(feature, Feature):
        at.notes.count(f"{_title(statement)} {feature or 'is not read'}", statement.line)
        return
    if feature.odd:
        at.notes.count(f"{_title(statement)} {feature.odd}", statement.line)
    at.run.actuals.append(
        Actual(feature, at.run.nominals.get(key), dict(at.run.tolerances.get(key, ())), at.heading.moment)
    )
    at.last = key


def _tolerance(at: Interpreter, statement: Words) -> None:
    limits = _stated(at, statement, lambda: tolerance_of(statement, at.settings))
    if isinstance(limits, Tolerance):
        shared(limits, at.limited(statement.label), at.run)
    elif limits is not None:
        at.notes.say(f"T({statement.label}) {limits}: no limits are taken from it", statement.line)


def _result(at: Interpreter, statement: Words) -> None:
    result = result_of(statement, at.settings)
    if isinstance(result, Result):
        features = at.about(statement.label)
        if result.what not in BETWEEN and at.last in features:
            features = (at.last,)  # of several that are output together, the one that stands before
        limits = at.run.by_label.get(key_of(statement.label))  # a label may mean another tolerance further on
        at.run.found.append(RunResult(result, features, at.heading.moment, limits))
    elif result is None:
        at.notes.count(f"{_title(statement)} is not read", statement.line)
    else:
        at.notes.say(f"TA({statement.label}) {result}", statement.line)


def _stated(
    at: Interpreter, statement: Words, read: Callable[[], Feature | Tolerance | str | None]
) -> Feature | Tolerance | str | None:
    """Reads a feature or a tolerance. A program may state it by variables: then it is unknown, with a remark."""
    try:
        stated = read()
    except TrueloopError as error:
        if error.code != "MSR-NUMBER":
            raise
        at.notes.count(f"{statement.kind}({statement.label}): {error.message}; it is not known", statement.line)
        return None
    if stated is None:
        at.notes.count(f"{_title(statement)} is not read", statement.line)
    return stated


def _points(at: Interpreter, statement: Words) -> None:
    """`PTDATA/CART,x,y,z,i,j,k` and `RAWDAT/…`: single points of the feature that is output."""
    words = {text.upper() for text in statement.fields if text.upper() in WORDS}
    texts = [text for text in statement.fields if text.upper() not in WORDS and label_in(text) is None]
    numbers, polar = [number_of(text, at.settings, statement.line) for text in texts], "POL" in words
    if len(numbers) not in (3, 6) or None in numbers:
        at.notes.count(f"{statement.word} with {len(numbers)} numbers is not read", statement.line)
        return
    mm = at.settings.length_factor(statement.line)
    a, b, c, *direction = [number or 0.0 for number in numbers]
    place = at.settings.place(polar, (a * mm, b * at.settings.deg if polar else b * mm, c * mm))
    normal = None if not direction else at.settings.frame.vector((direction[0], direction[1], direction[2]))
    at.run.loose.append(("".join(at.output[:1]), place, normal))


def _units(at: Interpreter, statement: Words) -> None:
    at.settings = with_units(at.settings, statement)


def _plane(at: Interpreter, statement: Words) -> None:
    plane = statement.fields[0].upper() if statement.fields else ""
    if plane in PLANES:
        at.settings = replace(at.settings, plane=plane)


def _coordinates(at: Interpreter, statement: Words) -> None:
    datums, frame = moved(statement, at.settings, at.frames, at.datums, measured=at.run.measured)
    if frame is None:  # other datums: what was measured before them was counted from the machine's zero
        if at.run.measured:
            at.notes.say("what was measured before these datums is kept apart: it has another zero", statement.line)
            at.run.frame = "device"
            at.apart()
            at.run.frame = "part"
        frame = FIRST
    at.datums, at.settings = datums, replace(at.settings, frame=frame)
    at.frames[key_of(statement.label)] = frame


def _name(at: Interpreter, statement: Words) -> None:
    meant = NAMES.get(statement.word) or NAMES[statement.kind]
    text = unquoted(statement.fields[0]) if statement.fields else ""
    other = getattr(at.heading, meant) not in ("", text)
    at.heading = at.heading.named(meant, text)
    at.begin(sure=other and meant in NEW_PART)


def _file(at: Interpreter, statement: Words) -> None:
    """A file's begin: what an earlier one in the same file said of part and time holds no longer."""
    text = unquoted(statement.fields[0]) if statement.fields else ""
    if at.run.measured:
        at.heading = Heading(text)
    elif at.held is not None:
        at.heading = Heading(text, date=at.heading.date, time=at.heading.time)
    elif statement.word == "FILNAM" or not at.heading.file:
        at.heading = replace(at.heading, file=text)
    at.begin(sure=True)


def _moment(at: Interpreter, statement: Words) -> None:
    text = "/".join(statement.fields)
    found = (DATE if statement.word == "DATE" else TIME).fullmatch(text)
    try:
        if found is None:
            raise ValueError(text)
        numbers = tuple(int(number) for number in found.groups() if number is not None)
        at.heading = with_date(at.heading, *numbers) if statement.word == "DATE" else with_time(at.heading, numbers)
    except ValueError:
        at.notes.say(f"{statement.word} {text!r} is not read: year/month/day or hour:minute:second", statement.line)
    if statement.word == "DATE" or not at.run.measured:
        at.begin(sure=False)


def _end(at: Interpreter, _statement: Words) -> None:
    at.heading = Heading()
    at.begin(sure=True)


Do = Callable[[Interpreter, Words], None]
BY_KIND: Final[dict[str, Do]] = {"F": _nominal, "FA": _actual, "T": _tolerance, "TA": _result}
BY_WORD: Final[dict[str, Do]] = {
    **dict.fromkeys(OUTPUTS, _output),
    **dict.fromkeys(("DATSET", "TRANS", "ROTATE", "RECALL"), _coordinates),
    **dict.fromkeys(("DATE", "TIME"), _moment),
    **dict.fromkeys(("FILNAM", "DMISMN"), _file),
    **dict.fromkeys(("PTDATA", "RAWDAT"), _points),
    "UNITS": _units,
    "WKPLAN": _plane,
    "ENDFIL": _end,
}
