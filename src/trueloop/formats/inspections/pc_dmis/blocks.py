"""A PC-DMIS report as blocks, one a dimension: what it measures of which feature, its unit, and its rows by column."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

COLUMNS: Final = {
    "AX": "axis",
    "NOMINAL": "nominal",
    "NOM": "nominal",
    "+TOL": "plus",
    "-TOL": "minus",
    "BONUS": "bonus",
    "MEAS": "actual",
    "ACTUAL": "actual",
    "MEASURED": "actual",
    "MAX": "max",
    "MIN": "min",
    "DEV": "deviation",
    "DEVANG": "angle",
    "OUTTOL": "outside",
    "OUT-TOL": "outside",
}
"""By the words of the heading; which there are, and in which order, is a setting."""
HEADING: Final = re.compile(r"\s*AX(?:IS)?\s+(?=.*(?:MEAS|ACTUAL|DEV))", re.IGNORECASE)
BLOCK: Final = re.compile(r"\s*DIM(?:ENSION)?\s+(\S+?)\s*=\s*(.+)", re.IGNORECASE)
LABEL: Final = re.compile(r"\W*(MM|IN|INCH|DEG)\b\s+(\S+)(?:\s+-\s+(.+))?\s*", re.IGNORECASE)
"""How a printed report names a dimension: `MM   LOC1 - CIR1`."""
ENDED: Final = re.compile(
    r"\s*END\s+OF\s+DIMENSION|\s*DIM(?:ENSION)?\s|\s*(?:PART NAME|SER NUMBER|REV NUMBER)\b", re.IGNORECASE
)
UNITS: Final = re.compile(r"\bUNITS\s*=\s*(MM|INCH|IN|DEG)\b", re.IGNORECASE)
FEATURE: Final = re.compile(r"\b(?:OF|FROM)\s+(?:SET\s+OF\s+)?(\w+)\s+([^\s,]+)", re.IGNORECASE)
OTHER: Final = re.compile(r"\bTO\s+(?:SET\s+OF\s+)?(\w+)\s+([^\s,]+)", re.IGNORECASE)
HEADER: Final = re.compile(
    r"\b(PART NAME|REV(?:ISION)? NUMBER|SER(?:IAL)? NUMBER|STATS COUNT|DATE|TIME|OPERATOR)\s*[:=]"
    r"\s*(.*?)(?=\s{2,}\S|\s*$|\s+TIME\s*[:=])",
    re.IGNORECASE,
)
GRAPH: Final = re.compile(r"[-#<>|*=]{3,}")


@dataclass(frozen=True)
class Line:
    """A row of a dimension: texts by column, empty ones left out."""

    cells: Mapping[str, str]
    line: int


@dataclass(frozen=True)
class Block:
    """A dimension: its name, what it is in words (`LOCATION OF CIRCLE CIR1`), unit as written, rows."""

    name: str
    what: str
    unit: str
    rows: tuple[Line, ...]
    line: int

    @property
    def feature(self) -> str:
        """The feature that it is a size of."""
        found = FEATURE.search(self.what)
        return found[2] if found else "" if " " in self.what else self.what

    @property
    def other(self) -> str:
        """The one from which a distance counts."""
        found = OTHER.search(self.what)
        return found[2] if found and "DISTANCE" in self.what.upper() else ""


@dataclass
class Run:
    """One run: what its header says, and its dimensions."""

    header: dict[str, str] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)
    not_understood: list[int] = field(default_factory=list)


def runs_in(text: str) -> list[Run]:
    """The runs of a report in their order: each begins with the name of its part."""
    runs = [Run()]
    lines = _joined(text)
    for at, (line, content) in enumerate(lines):
        for key, value in HEADER.findall(content):
            name = " ".join(key.upper().split())
            if name == "PART NAME" and (runs[-1].header.get(name) or runs[-1].blocks):
                runs.append(Run())
            if value.strip():
                runs[-1].header.setdefault(name, value.strip())
        if HEADING.match(content):
            runs[-1].blocks.append(_block(lines, at, line, runs[-1]))
    return [run for run in runs if run.blocks or run.header]


def _joined(text: str) -> list[tuple[int, str]]:
    """Lines, those that end with $ together with the next one."""
    out: list[tuple[int, str]] = []
    begun = ""
    for line, content in enumerate(text.expandtabs().splitlines(), 1):
        if content.rstrip().endswith("$") and not HEADING.match(content):
            begun += content.rstrip()[:-1]
            continue
        out.append((line, begun + content.rstrip()))
        begun = ""
    return out


def _block(lines: Sequence[tuple[int, str]], at: int, line: int, run: Run) -> Block:
    """The dimension whose heading of columns stands there: its name is above, its rows below."""
    name, what, unit = "", "", ""
    for _, above in reversed(lines[max(0, at - 4) : at]):
        if block := BLOCK.match(above):
            name, what = block[1], block[2]
            unit = found[1] if (found := UNITS.search(what)) else ""
            break
        if label := LABEL.fullmatch(above):
            unit, name, what = label[1], label[2], label[3] or ""
            break
        if HEADING.match(above) or above.upper().lstrip().startswith("END OF"):
            break
    rows = tuple(_rows(lines, at, run))
    return Block(name, UNITS.sub("", what).strip(" ,"), unit.upper(), rows, line)


def _rows(lines: Sequence[tuple[int, str]], at: int, run: Run) -> Iterator[Line]:
    heading = [(found[0].upper(), found.end()) for found in re.finditer(r"\S+", lines[at][1])]
    columns = [(COLUMNS.get(word, word.lower()), end) for word, end in heading]
    for line, content in (lines[k] for k in range(at + 1, len(lines))):
        if not content.strip() or ENDED.match(content) or HEADING.match(content) or LABEL.fullmatch(content):
            if content.strip():
                return
            continue
        tokens = [(found[0], found.end()) for found in re.finditer(r"\S+", content) if not GRAPH.fullmatch(found[0])]
        cells = _cells(columns, tokens)
        if cells is None:
            run.not_understood.append(line)
            return
        yield Line(cells, line)


def _cells(columns: Sequence[tuple[str, int]], tokens: Sequence[tuple[str, int]]) -> dict[str, str] | None:
    """The words of a row under the headings: all of them in order, else each under the one that ends where it ends.

    None: two would stand under one heading, or the row is none of an axis.
    """
    if len(tokens) < 2 or not re.fullmatch(r"[A-Z]{1,3}\d?", tokens[0][0], re.IGNORECASE):
        return None
    if len(tokens) == len(columns):
        return {name: word for (name, _), (word, _) in zip(columns, tokens, strict=True)}
    found: dict[str, str] = {"axis": tokens[0][0]}
    for word, end in tokens[1:]:
        name, _ = min(columns[1:], key=lambda column: abs(column[1] - end))
        if name in found:
            return None
        found[name] = word
    return found
