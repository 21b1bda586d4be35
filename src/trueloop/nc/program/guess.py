"""Recognises the dialect of a program by its words and its file's name, where they leave no doubt."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import read_program
from trueloop.nc.program.understood import NOT_UNDERSTOOD
from trueloop.wording import wording

FANUC: Final = ("fanuc-lathe", "fanuc-lathe-b", "fanuc-mill")
HAAS: Final = ("haas-lathe", "haas-mill")
LATHES: Final = ("fanuc-lathe", "fanuc-lathe-b", "haas-lathe")
MILLS: Final = ("fanuc-mill", "haas-mill")
MARKS: Final[tuple[tuple[str, int, tuple[str, ...], str], ...]] = (
    (r"^\s*\d*\s*BEGIN PGM\b", 10, ("heidenhain",), "BEGIN PGM"),
    (r"\bTOOL CALL\b|\bFMAX\b|\bCYCL DEF\b", 5, ("heidenhain",), "TOOL CALL, FMAX or CYCL DEF"),
    (r"^%_N_\w+_(MPF|SPF)|^;\$PATH=", 10, ("siemens",), "a head %_N_NAME_MPF"),
    (r"\b(GOTO[FB]|DIAMO[NF]|SUPA|MCALL|CYCLE\d+\s*\(|A?TRANS\b|MSG\s*\(|G500\b)", 6, ("siemens",), "CYCLE, DIAMON"),
    (r"^[^(;\n]*\bR\d+\s*=|\b(CR|RND|CHR)\s*=", 5, ("siemens",), "R1= or CR="),
    (r"#<\w+>|^\s*o<?\w+>?\s+(sub|call|if|while|repeat)\b", 8, ("linuxcnc",), "#<name> or an O word"),
    (r"\(\s*(debug|print|msg)\s*,|\bG64\s*P|\bG43\.1|\bG3[38]\.", 5, ("linuxcnc",), "(MSG, …), G64 P or G38.2"),
    (r"^[^(;\n]*\bG0?[78]\b(?!\.|\s*P)", 10, ("linuxcnc",), "G7 or G8 without P"),
    (r"\(UPD\s*,|\bTOV\(", 10, ("ge2000t",), "(UPD, …)"),
    (r"\bNLAP\w*|\bNAT\d+|\bV[CST][A-Z0-9]*\s*=|\bTG=|^\$", 8, ("okuma-lathe",), "NLAP1, VC1= or TG="),
    (r"\bG(154|187|103)\b|\bM97\b|\bHAAS\b", 8, HAAS, "G154, G187, M97 or the name Haas"),
    (r"\bG(05|08|10\.9|54\.1|68\.2)\b|\bFANUC\b", 8, FANUC, "G05, G08, G54.1 or the name Fanuc"),
    (r"^\s*[O:]\d{4,5}\b|\bM98\s*P|\bG65\s*P|#\d+\s*=", 4, (*FANUC, *HAAS), "O1000, M98 P or #1="),
    (r"\bT\d{4}\b|\bG50\s*S|\bG7[126]\s*(P|U|W)|\bG96\b", 5, LATHES, "T0101, G50 S or G71"),
    (r"\b[UW]-?\d*\.", 6, ("fanuc-lathe", "haas-lathe"), "U and W"),
    (r"\bG98\b.*\bF|\bG99\b.*\bF\.?0?\.\d", 2, ("fanuc-lathe", "haas-lathe"), "G98 or G99 beside a feed"),
    (r"\bY-?\d*\.?\d|\bG43\s*H|\bT\d+\s*M0?6\b|\bG8[1-9]\b.*\bR", 5, MILLS, "Y, G43 H or T1 M6"),
)  # fmt: skip
"""Marks of programs of some dialects alone: a pattern of a line, its points, the dialects, its name."""
ENDINGS: Final = {".mpf": "siemens", ".spf": "siemens", ".h": "heidenhain", ".ngc": "linuxcnc", ".min": "okuma-lathe"}
OF_ENDING: Final = 12
SURE: Final = 5
"""The best score counts so much at least, and so much more than the next one."""
LOOKED_AT: Final = 1 << 17


@dataclass(frozen=True)
class Score:
    """The evidence for a dialect: the sum of the marks' points, their names, and the number of words unknown to it."""

    points: int
    reasons: tuple[str, ...]
    strange: int


def scores(source: bytes, file: str | None = None) -> Mapping[str, Score]:
    """Scores the dialects for a program: marks in its first 128 KiB, and the ending of its file's name."""
    text = source[:LOOKED_AT].decode("latin-1")
    found = [(count, of, name) for pattern, count, of, name in MARKS if re.search(pattern, text, re.M | re.I)]
    ending = Path(file or "").suffix.lower()
    if ending in ENDINGS:
        found.append((OF_ENDING, (ENDINGS[ending],), f"the ending {ending}"))
    result = {}
    for name, dialect in DIALECTS.items():
        own = [(count, f"a mark of {name}") for count, mark in dialect.marks if re.search(mark, text, re.M | re.I)]
        if own or not dialect.like:  # a variant without a mark of its own is not told from the control that it is like
            marks = [*own, *((count, mark) for count, of, mark in found if name in of or dialect.like in of)]
            points, reasons = sum(count for count, _ in marks), tuple(mark for _, mark in marks)
            result[name] = Score(points, reasons, _strange_words(source, name))
    return result


def guess_dialect(source: bytes, file: str | None = None, option: str = "--dialect {}") -> str:
    """Returns the only dialect that knows every word; of several the one with the most points.

    Where none knows every word, the one with the most points is taken, if it knows nearly as many words as any.
    `option` is how a user states it. Raises NC-DIALECT, with the scores and their reasons, where that is in doubt.
    """
    all_of = scores(source, file)
    least = min(score.strange for score in all_of.values())
    fitting = {name: score for name, score in all_of.items() if score.strange <= (0 if least == 0 else 2 * least)}
    if least == 0 and len(fitting) == 1:
        return next(iter(fitting))
    first, *rest = sorted(fitting, key=lambda name: -fitting[name].points)
    second = fitting[rest[0]].points if rest else 0
    if fitting[first].points >= SURE and fitting[first].points - second >= SURE:
        return first
    listed = sorted(all_of, key=lambda name: (all_of[name].strange, -all_of[name].points))
    raise Code.NC_DIALECT.refusal(
        wording(
            "the program does not tell its dialect: {listed}",
            listed="; ".join(_told(name, all_of[name]) for name in listed[:5]),
        ),
        hint=f"say which: {' or '.join(map(option.format, list(fitting) if least == 0 else DIALECTS))}",
        place=Place(file),
    )


def _told(name: str, score: Score) -> str:
    by = f" ({', '.join(score.reasons)})" if score.reasons else ""
    return f"{name} {score.points} points{by}, {score.strange} strange words"


def likeliest_dialect(source: bytes) -> str:
    """Returns the dialect with the fewest strange words, the first of several: enough to split a line into words."""
    return min(DIALECTS, key=lambda name: _strange_words(source, name))


def _strange_words(source: bytes, dialect: str) -> int:
    return sum(finding.code in NOT_UNDERSTOOD for finding in read_program(source, dialect).findings)
