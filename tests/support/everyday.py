"""Finish programs of shafts as they are written every day, drawn by chance, and a reader of what they drive.

The reader knows nothing of the product: X a diameter, U and W, `,C` and `,R`, R, I and K, subprograms (M98), G70
between two numbers and WHILE loops of fanuc-lathe; DIAMON, CR=, CHR= and RND= of siemens; G7 of linuxcnc. Lengths mm,
x a radius.
"""

import math
import re
from dataclasses import dataclass
from random import Random

Point = tuple[float, float]


@dataclass(frozen=True)
class Piece:
    """A feature from the front to the chuck: its name, where it ends, and of an arc its centre."""

    name: str
    end: Point
    centre: Point | None = None


@dataclass(frozen=True)
class Everyday:
    """A program, its profile from the front, and what to write into a job."""

    dialect: str
    text: str
    start: Point
    pieces: tuple[Piece, ...]
    nose_radius_mm: float
    form: str


@dataclass(frozen=True)
class Driven:
    """A move at feed under G41 or G42."""

    start: Point
    end: Point
    centre: Point | None


def everyday(seed: int) -> Everyday:
    """The program of a seed."""
    rng = Random(seed)
    dialect = rng.choice(["fanuc-lathe", "fanuc-lathe", "siemens", "linuxcnc"])
    start, pieces = _profile(rng)
    iso = dialect == "fanuc-lathe"
    words = rng.choice(
        ["XZ", "UW", "W", "corners"] if iso else ["XZ", "G91"] if dialect == "linuxcnc" else ["XZ", "corners"]
    )
    way_in = rng.choice(["along z", "rapid", "slanting", "arc"])
    way_out = rng.choice(["X", "X Z", "retract", *(["U", "home"] if iso else [])])
    body = rng.choice(["plain", "M98", "M98 twice", "G70", "G70 twice", "loop"]) if iso else "plain"
    tool = body != "plain" or rng.random() < 0.7
    lines = _text(dialect, start, pieces, (words, way_in, way_out, body), tool)
    form = ", ".join([dialect, words, f"in {way_in}", f"out {way_out}", body, "T" if tool else "no T"])
    return Everyday(dialect, "\n".join([*lines, ""]), start, pieces, rng.choice([0.4, 0.8]), form)


def _profile(rng: Random) -> tuple[Point, tuple[Piece, ...]]:
    r1, r2 = rng.choice([8.0, 11.0]), rng.choice([15.0, 16.5])
    z1, z2 = rng.choice([-14.0, -25.0]), rng.choice([-40.0, -52.0])
    pieces: list[Piece] = []

    def corner(name: str, face: str, r: float, z: float) -> None:
        size, around = rng.choice([0.5, 1.0]), rng.random() < 0.4
        pieces.append(Piece(face, (r - size, z)))
        pieces.append(Piece(name, (r, z - size), (r - size, z - size) if around else None))

    corner("edge1", "front", r1, 0.0)
    fillet = rng.choice([0.0, 2.0])
    pieces.append(Piece("seat1", (r1, z1 + fillet)))
    if fillet:
        pieces.append(Piece("fillet", (r1 + fillet, z1), (r1 + fillet, z1 + fillet)))
    corner("edge2", "shoulder", r2, z1)
    pieces.append(Piece("seat2", (r2, z2)))
    return (3.0, 0.0), tuple(pieces)


def _text(
    dialect: str, start: Point, pieces: tuple[Piece, ...], form: tuple[str, str, str, str], tool: bool
) -> list[str]:
    words, way_in, way_out, body = form
    x_far = pieces[-1].end[0] + 4
    head = {
        "fanuc-lathe": ["O0001", "G21 G40 G99", "T0101", "G97 S900 M3"],
        "siemens": ["G18 G71 G90 G40 DIAMON G54", "T1 D1", "G97 S900 M4 G95 F0.1"],
        "linuxcnc": ["G18 G21 G7 G90 G40 G54", "T1 M6", "G43", "G97 S900 M3 G95 F0.1"],
    }[dialect]
    head = [line for line in head if tool or not line.startswith("T")]
    lead = {
        "along z": [f"G0 {_x(start[0])} Z4.", "G42 G1 Z0. F0.1"],
        "rapid": [f"G0 {_x(start[0])} Z6.", "G42 G0 Z3.", "G1 Z0. F0.1"],
        "slanting": [f"G0 {_x(start[0] + 7)} Z5.", f"G42 G1 {_x(start[0])} Z0. F0.1"],
        "arc": [
            f"G0 {_x(start[0] - 2)} Z8.",
            "G42 G1 Z2. F0.1",
            f"G2 {_x(start[0])} Z0. {'CR=2.' if dialect == 'siemens' else 'I2. K0.'}",
        ],
    }[way_in]
    out = {
        "X": [f"G40 G1 {_x(x_far)}"],
        "X Z": [f"G40 G1 {_x(x_far)} Z{pieces[-1].end[1] + 1:.3f}"],
        "retract": [f"G1 {_x(x_far)}", f"G40 G0 {_x(x_far + 3)}"],
        "U": ["G40 G1 U9."],
        "home": [f"G1 {_x(x_far)}", "G40", "G28 U0 W0"],
    }[way_out]
    cut = _cut(dialect, start, pieces, words)
    away = f"G0 {_x(70)} Z70."
    end = "M2" if dialect == "linuxcnc" else "M30"
    if body in ("M98", "M98 twice"):
        again = ["T0303", lead[0], "M98 P22", away] if body == "M98 twice" else []
        return [*head, lead[0], "M98 P22", away, *again, end, "O0022", *lead[1:], *cut, *out, "M99"]
    if body in ("G70", "G70 twice"):
        at = f"G0 {_x(x_far + 1)} Z2."
        contour = [f"N10 G0 G42 {_x(start[0])}", "G1 Z0. F0.1", *cut, f"N20 G40 G1 {_x(x_far)}"]
        again = ["T0303", at, "G70 P10 Q20", away] if body == "G70 twice" else []
        rough = ["G71 U1. R0.5", "G71 P10 Q20 U0.4 W0.1 F0.2"]
        return [*head, at, *rough, *contour, at, "G70 P10 Q20", away, *again, end]
    if body == "loop":
        return [*head, "#100=0", "WHILE[#100LT3]DO1", *lead, *cut, *out, away, "#100=#100+1", "END1", end]
    return [*head, *lead, *cut, *out, away, end]


def _cut(dialect: str, start: Point, pieces: tuple[Piece, ...], words: str) -> list[str]:
    """The blocks of the contour; `words`: positions, increments, increments of chamfers alone, or corners by a word."""
    lines, at, made = (["G91"] if words == "G91" else []), start, False
    for piece, after in zip(pieces, [*pieces[1:], None], strict=True):
        (x, z), begin = piece.end, at
        at = piece.end
        if made:
            made = False
            continue
        if words == "corners" and after is not None and after.name.startswith("edge"):
            size = after.end[0] - x
            names = ("RND=", "CHR=") if dialect == "siemens" else (",R", ",C")
            lines.append(f"G1 {_x(after.end[0])} {names[0] if after.centre else names[1]}{size:.3f}")
            made = True
            continue
        by_steps = words in ("UW", "G91") or (words == "W" and piece.name.startswith("edge"))
        dx, dz = x - begin[0], z - begin[1]
        axes = ("X", "Z") if words == "G91" else ("U", "W")
        text = []
        if dx or piece.centre:
            text.append(f"{axes[0]}{2 * dx:.3f}" if by_steps and words != "W" else _x(x))
        if dz or piece.centre:
            text.append(f"{axes[1]}{dz:.3f}" if by_steps else f"Z{z:.3f}")
        if piece.centre is None:
            lines.append(" ".join(["G1", *text]))
            continue
        code = "G2" if piece.name == "fillet" else "G3"
        radius = math.dist(begin, piece.centre)
        by_centre = f"I{piece.centre[0] - begin[0]:.3f} K{piece.centre[1] - begin[1]:.3f}"
        lines.append(" ".join([code, *text, f"CR={radius:.3f}" if dialect == "siemens" else by_centre]))
    return [*lines, *(["G90"] if words == "G91" else [])]


def _x(radius: float) -> str:
    return f"X{2 * radius:.3f}"


def driven(text: str, dialect: str) -> list[list[Driven]]:
    """The passes under G41 or G42 that a program drives, each with its corners made."""
    lines = [re.sub(r"\(.*?\)|;.*", "", line).strip() for line in text.splitlines()]
    reader = _Reader(lines, dialect)
    reader.run(0, len(lines))
    return [_with_corners(one) for one in reader.passes if one]


class _Reader:
    def __init__(self, lines: list[str], dialect: str) -> None:
        self.lines, self.dialect = lines, dialect
        self.at, self.code, self.on, self.steps = (0.0, 0.0), 0, False, False
        self.passes: list[list[tuple[Driven, tuple[str, float] | None]]] = [[]]
        self.names: dict[str, float] = {}

    def find(self, start: str) -> int:
        return next(k for k, line in enumerate(self.lines) if re.match(rf"{start}(?!\d)", line))

    def run(self, first: int, last: int) -> None:
        k = first
        while k < last:
            line = self.lines[k]
            if re.search(r"M30|M99|M0?2\b", line):
                return
            if found := re.search(r"M98 P(\d+)", line):
                self.run(self.find(f"O0*{found[1]}") + 1, len(self.lines))
            elif found := re.search(r"G7([01]).*P(\d+) Q(\d+)", line):
                bounds = self.find(f"N{found[2]}"), self.find(f"N{found[3]}") + 1
                if found[1] == "0":
                    back = self.at
                    self.run(*bounds)
                    self.at, self.code = back, 0
                else:
                    k = bounds[1] - 1
            elif found := re.match(r"(#\d+)=(?:(#\d+)\+)?([\d.]+)", line):
                self.names[found[1]] = self.names.get(found[2] or "", 0.0) + float(found[3])
            elif found := re.match(r"WHILE\[(#\d+)LT(\d+)\]DO1", line):
                end = self.find("END1")
                while self.names[found[1]] < float(found[2]):
                    self.run(k + 1, end)
                k = end
            else:
                self.block(line)
            k += 1

    def block(self, line: str) -> None:
        if re.search(r"\b(G28|TRANS|DIAMON|G43|G71)\b", line) and "G18" not in line:
            self.passes.append([])
            return
        found = re.findall(r"(,C|,R|CR|RND|CHR|[A-Z])=?([-+]?\d*\.?\d+)", re.sub(r"^N\d+", "", line))
        values = {name: float(value) for name, value in found if name != "G"}
        for code in (int(float(value)) for name, value in found if name == "G"):
            self.code = code if code in (0, 1, 2, 3) else self.code
            self.steps = code == 91 if code in (90, 91) else self.steps
            if code in (40, 41, 42):
                self.on = code != 40
                self.passes.append([])
        if not values.keys() & set("XZUW"):
            return
        x, z = self.at
        x += values.get("U", values["X"] if self.steps and "X" in values else 0.0) / 2
        z += values.get("W", values["Z"] if self.steps and "Z" in values else 0.0)
        if not self.steps:
            x, z = values["X"] / 2 if "X" in values else x, values.get("Z", z)
        corner = next(((name, values[name]) for name in (",C", ",R", "CHR", "RND") if name in values), None)
        if self.on and self.code and (x, z) != self.at:
            self.passes[-1].append((Driven(self.at, (x, z), self.centre((x, z), values)), corner))
        self.at = (x, z)

    def centre(self, end: Point, values: dict[str, float]) -> Point | None:
        if self.code not in (2, 3):
            return None
        (x, z), radius = self.at, values.get("R", values.get("CR"))
        if radius is None:
            return x + values.get("I", 0.0), z + values.get("K", 0.0)
        dx, dz = end[0] - x, end[1] - z
        chord = math.hypot(dx, dz)
        high = math.sqrt(max(radius**2 - chord**2 / 4, 0.0)) * (1 if self.code == 3 else -1)
        return x + dx / 2 + high * dz / chord, z + dz / 2 - high * dx / chord


def _with_corners(moves: list[tuple[Driven, tuple[str, float] | None]]) -> list[Driven]:
    """Chamfers and roundings between square lines put in."""
    done: list[Driven] = []
    cut_mm = 0.0
    for k, (move, corner) in enumerate(moves):
        begin = _towards(move.start, move.end, cut_mm)
        cut_mm = 0.0 if corner is None else corner[1]
        end = _towards(move.end, move.start, cut_mm)
        done.append(Driven(begin, end, move.centre))
        if corner is not None:
            after = _towards(move.end, moves[k + 1][0].end, cut_mm)
            turn = (end[0] + after[0] - move.end[0], end[1] + after[1] - move.end[1])
            done.append(Driven(end, after, turn if corner[0] in (",R", "RND") else None))
    return done


def _towards(start: Point, end: Point, by_mm: float) -> Point:
    if not by_mm:
        return start
    share = by_mm / math.dist(start, end)
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


def off_mm(moves: list[Driven], at: Point, normal: Point) -> float:
    """How far the path lies from a place along its normal; infinite where it does not pass there."""
    found = [off for move in moves for off in _crossings(move, at, normal)]
    return min(found, key=abs, default=math.inf)


def _crossings(move: Driven, at: Point, normal: Point) -> list[float]:
    (x0, z0), (x1, z1) = move.start, move.end
    if move.centre is None:
        dx, dz = x1 - x0, z1 - z0
        across = normal[0] * dz - normal[1] * dx
        if abs(across) < 1e-9:
            return []
        off = ((x0 - at[0]) * dz - (z0 - at[1]) * dx) / across
        share = ((x0 - at[0]) * normal[1] - (z0 - at[1]) * normal[0]) / across
        return [off] if -1e-6 <= share <= 1 + 1e-6 else []
    cx, cz = at[0] - move.centre[0], at[1] - move.centre[1]
    half, radius = cx * normal[0] + cz * normal[1], math.dist(move.start, move.centre)
    root = half**2 - cx**2 - cz**2 + radius**2
    if root < 0:
        return []
    middle = ((x0 + x1) / 2 - move.centre[0], (z0 + z1) / 2 - move.centre[1])
    offs = [-half - math.sqrt(root), -half + math.sqrt(root)]
    on = [
        o
        for o in offs
        if (cx + o * normal[0]) * middle[0] + (cz + o * normal[1]) * middle[1] >= math.hypot(*middle) ** 2 - 4e-3
    ]
    return on


def places(case: Everyday) -> list[tuple[str, Point, Point]]:
    """Feature, place and outward normal: five along each, not at its ends."""
    found, begin = [], case.start
    for piece in case.pieces:
        for share in (0.15, 0.3, 0.5, 0.7, 0.85):
            x, z = (a + share * (b - a) for a, b in zip(begin, piece.end, strict=True))
            normal = (-(piece.end[1] - begin[1]), piece.end[0] - begin[0])
            if piece.centre is not None:
                x0, z0 = begin[0] - piece.centre[0], begin[1] - piece.centre[1]
                x1, z1 = piece.end[0] - piece.centre[0], piece.end[1] - piece.centre[1]
                turn = math.atan2(x1 * z0 - z1 * x0, x0 * x1 + z0 * z1)
                angle, radius = math.atan2(x0, z0) + share * turn, math.dist(begin, piece.centre)
                side = -1 if piece.name == "fillet" else 1
                normal = (side * math.sin(angle), side * math.cos(angle))
                x, z = piece.centre[0] + radius * math.sin(angle), piece.centre[1] + radius * math.cos(angle)
            size = math.hypot(*normal)
            found.append((piece.name, (x, z), (normal[0] / size, normal[1] / size)))
        begin = piece.end
    return found
