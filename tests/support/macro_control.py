"""A small control that runs probing programs of Fanuc, Haas and Siemens against a part, written apart from trueloop.

It knows what these programs use and refuses everything else: moves in X (a diameter) and Z, skip moves that the part or
a dead probe decide, variables of positions, conditions, alarms. A variable holds a number; X and Z of the place last
touched are #5061 and the one above, or $AA_MW[X] and $AA_MW[Z].
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field

Point = tuple[float, float]
Contact = Callable[[Point, Point], Point | None]
"""Where the probe's ball is stopped on its way from one place (x a radius, z) to another, None where it is not."""

WORD = re.compile(r"([XZ])(?:=(R\d)|(#\d+)|(-?\d*\.\d*))")
ASSIGNED = re.compile(r"(R\d|#10\d)=(#506\d|\$AA_MW\[[XZ]\])([+-]\d*\.\d*)?")


class UnknownLineError(Exception):
    """A line that the control does not know."""


@dataclass
class Ran:
    """What happened: moves as (start, end), their lines, places logged, the alarm that ended it, lines not known."""

    moves: list[tuple[Point, Point]] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    logged: list[Point] = field(default_factory=list)
    alarm: int | None = None
    ended: bool = False
    other: list[str] = field(default_factory=list)


def run_fanuc(text: str, contact: Contact, z_axis: int, *, skip_kept: bool = False) -> Ran:
    """Runs G code system A. `skip_kept`: #5061 keeps the touch before where a move was not skipped."""
    ran, at, latched, held = Ran(), (200.0, 200.0), (0.0, 0.0), dict[str, float]()
    for line in text.splitlines():
        if ran.alarm is not None or ran.ended:
            break
        if condition := re.fullmatch(r"IF\[(.*)(LT|GE) ([\d.]+)\]THEN #3000=(\d+)\(.*\)", line):
            off = _value(condition[1], at, latched, held, z_axis)
            if (off < float(condition[3])) == (condition[2] == "LT"):
                ran.alarm = int(condition[4])
        elif line.startswith(("G0 ", "G1 ", "G31 ")):
            end = _end(line, at, held)
            stopped = contact(at, end) if line.startswith("G31") else None
            ran.moves.append((at, stopped or end))
            ran.lines.append(line)
            at = stopped or end
            latched = at if line.startswith("G31") and (stopped or not skip_kept) else latched
        elif line == "M30":
            ran.ended = True
        elif line.startswith("DPRNT"):
            ran.logged.append((held["#101"] / 2.0, held["#102"]))
        elif ASSIGNED.fullmatch(line):
            held |= _assigned(line, {"#5061": 2.0 * latched[0], f"#506{z_axis}": latched[1]})
        elif not re.fullmatch(r"%|O\d{4}|\(.*\)|G2[01] G18 G40 G98|M5|G5\d|T\d{4}|POPEN|PCLOS", line):
            ran.other.append(line)
    return ran


def _value(expression: str, at: Point, latched: Point, held: dict[str, float], z_axis: int) -> float:
    """[ABS[#5041-[x]]+ABS[#504k-[z]]] at a place, or [ABS[#5061-#101]+ABS[#506k-#102]] of the place last touched."""
    stands = re.fullmatch(r"\[ABS\[#5041-\[(.+)\]\]\+ABS\[#504(\d)-\[(.+)\]\]\]", expression)
    moved = re.fullmatch(r"\[ABS\[#5061-(#101)\]\+ABS\[#506(\d)-(#102)\]\]", expression)
    found = stands or moved
    if found is None or int(found[2]) != z_axis:
        raise UnknownLineError(expression)
    x, z = (held[word] if word in held else float(word) for word in (found[1], found[3]))
    place = latched if moved else at
    return abs(2.0 * place[0] - x) + abs(place[1] - z)


def _assigned(line: str, results: dict[str, float]) -> dict[str, float]:
    """Variables and their new values: `#101=#5061+1.5`."""
    found = [match.groups() for match in map(ASSIGNED.fullmatch, line.split()) if match]
    if len(found) != len(line.split()):
        raise UnknownLineError(line)
    return {name: results[result] + float(added or 0.0) for name, result, added in found}


def run_siemens(text: str, contact: Contact) -> Ran:
    """Runs a program of an 840D; after an alarm the operator starts it on."""
    ran, at, touched, latched, held = Ran(), (200.0, 200.0), False, (0.0, 0.0), dict[str, float]()
    lines = text.splitlines()
    k = 0
    while k < len(lines) and not ran.ended:
        line = lines[k]
        k += 1
        if jump := re.fullmatch(r"IF \$AC_MEA\[1\]==([01]) GOTOF (\w+)", line):
            if touched == (jump[1] == "1"):
                k = lines.index(f"{jump[2]}:", k)
        elif near := re.fullmatch(r"IF ABS\(\$AA_MW\[X\]-R1\)\+ABS\(\$AA_MW\[Z\]-R2\)<(.+) GOTOF (\w+)", line):
            if abs(2.0 * latched[0] - held["R1"]) + abs(latched[1] - held["R2"]) < float(near[1]):
                k = lines.index(f"{near[2]}:", k)
        elif line.startswith(("G0 ", "G1 ", "MEAS=1 G1 ")):
            end = _end(line, at, held)
            stopped = contact(at, end) if line.startswith("MEAS") else None
            touched, latched = (
                (stopped is not None, stopped or latched) if line.startswith("MEAS") else (touched, latched)
            )
            ran.moves.append((at, stopped or end))
            ran.lines.append(line)
            at = stopped or end
        elif alarm := re.fullmatch(r"SETAL\((\d+)\)", line):
            ran.alarm = int(alarm[1])
        elif line == "M30":
            ran.ended = True
        elif line.startswith("WRITE") and "<<" in line:
            ran.logged.append((held["R1"] / 2.0, held["R2"]))
        elif line.startswith("R1="):
            held |= _assigned(line, {"$AA_MW[X]": 2.0 * latched[0], "$AA_MW[Z]": latched[1]})
        elif not re.fullmatch(r";.*|DEF INT FAULT|G7[01]0 .*|T\d+ D1|M5|M0|STOPRE|WRITE.*|\w+:", line):
            ran.other.append(line)
    return ran


def _end(line: str, at: Point, held: dict[str, float]) -> Point:
    words = {name: held[r or hash_] if r or hash_ else float(text) for name, r, hash_, text in WORD.findall(line)}
    return words.get("X", 2.0 * at[0]) / 2.0, words.get("Z", at[1])
