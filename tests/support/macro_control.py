"""A small control that runs probing programs of Fanuc, Haas and Siemens against a part, written apart from trueloop.

It knows what these programs use and refuses everything else: moves in X (a diameter) and Z, skip moves that the part or
a dead probe decide, variables of positions, conditions, alarms.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field

Point = tuple[float, float]
Contact = Callable[[Point, Point], Point | None]
"""Where the probe's ball is stopped on its way from one place (x a radius, z) to another, None where it is not."""

WORD = re.compile(r"([XZF])(-?\d*\.\d*)")


class UnknownLineError(Exception):
    """A line that the control does not know."""


@dataclass
class Ran:
    """What happened: moves as (start, end), places logged, the alarm that ended the program, lines not known."""

    moves: list[tuple[Point, Point]] = field(default_factory=list)
    logged: list[Point] = field(default_factory=list)
    alarm: int | None = None
    ended: bool = False
    other: list[str] = field(default_factory=list)


def run_fanuc(text: str, contact: Contact, z_axis: int, *, skip_kept: bool = False) -> Ran:
    """Runs G code system A. `skip_kept`: #5061 keeps the touch before where a move was not skipped."""
    ran, at, latched = Ran(), (200.0, 200.0), (0.0, 0.0)
    for line in text.splitlines():
        if ran.alarm is not None or ran.ended:
            break
        if condition := re.fullmatch(r"IF\[(.*)(LT|GE) ([\d.]+)\]THEN #3000=(\d+)\(.*\)", line):
            off = _value(condition[1], at, z_axis)
            if (off < float(condition[3])) == (condition[2] == "LT"):
                ran.alarm = int(condition[4])
        elif line.startswith(("G0 ", "G1 ", "G31 ")):
            end = _end(line, at)
            stopped = contact(at, end) if line.startswith("G31") else None
            ran.moves.append((at, stopped or end))
            at = stopped or end
            latched = at if line.startswith("G31") and (stopped or not skip_kept) else latched
        elif line == "M30":
            ran.ended = True
        elif line.startswith("DPRNT"):
            ran.logged.append(latched)
        elif not re.fullmatch(r"%|O\d{4}|\(.*\)|G2[01] G18 G40 G98|M5|G5\d|T\d{4}|POPEN|PCLOS|#10[12]=#506[123]", line):
            ran.other.append(line)
    return ran


def _value(expression: str, at: Point, z_axis: int) -> float:
    """[ABS[#5041-[x]]+ABS[#504k-[z]]] at a place."""
    found = re.fullmatch(r"\[ABS\[#5041-\[(.+)\]\]\+ABS\[#504(\d)-\[(.+)\]\]\]", expression)
    if found is None or int(found[2]) != z_axis:
        raise UnknownLineError(expression)
    return abs(2.0 * at[0] - float(found[1])) + abs(at[1] - float(found[3]))


def run_siemens(text: str, contact: Contact) -> Ran:
    """Runs a program of an 840D; after an alarm the operator starts it on."""
    ran, at, touched = Ran(), (200.0, 200.0), False
    lines = text.splitlines()
    k = 0
    while k < len(lines) and not ran.ended:
        line = lines[k]
        k += 1
        if jump := re.fullmatch(r"IF \$AC_MEA\[1\]==([01]) GOTOF (\w+)", line):
            if touched == (jump[1] == "1"):
                k = lines.index(f"{jump[2]}:", k)
        elif line.startswith(("G0 ", "G1 ", "MEAS=1 G1 ")):
            end = _end(line, at)
            stopped = contact(at, end) if line.startswith("MEAS") else None
            touched = stopped is not None if line.startswith("MEAS") else touched
            ran.moves.append((at, stopped or end))
            at = stopped or end
        elif alarm := re.fullmatch(r"SETAL\((\d+)\)", line):
            ran.alarm = int(alarm[1])
        elif line == "M30":
            ran.ended = True
        elif line.startswith("WRITE") and "<<" in line:
            ran.logged.append(at)
        elif not re.fullmatch(r";.*|DEF INT FAULT|G7[01] .*|T\d+ D1|M5|M0|STOPRE|R1=.*|WRITE.*|\w+:", line):
            ran.other.append(line)
    return ran


def _end(line: str, at: Point) -> Point:
    words = {name: float(number) for name, number in WORD.findall(line)}
    return words.get("X", 2.0 * at[0]) / 2.0, words.get("Z", at[1])
