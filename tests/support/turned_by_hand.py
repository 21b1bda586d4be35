"""A turned part drawn and touched by hand, and its program read by a few lines: for programs that shops wrote.

Shares no code with trueloop. x is a radius, mm; normals point out of the material, which is on the right of the way
from chuck to free end.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from trueloop.arrays import Array

Key: TypeAlias = tuple[int, int]
"""A tool and its edge, as the program calls them; (0, 0) before any."""

WORD: Final = re.compile(r"([A-Z]+)\s*=?\s*([-+]?(?:\d+\.?\d*|\.\d+))")


LEAST_MM: Final = 2.2
"""No probe's ball touches a shorter line."""


@dataclass(frozen=True)
class Piece:
    """One feature: straight, or an arc about `centre`, and the edge that cuts it; None: none that is followed."""

    name: str
    start: tuple[float, float]
    end: tuple[float, float]
    centre: tuple[float, float] | None
    convex: bool
    edge: Key | None

    def at(self, share: float) -> tuple[Array, Array]:
        """The point at a share of the way, and the outward normal there."""
        start, end = np.array(self.start), np.array(self.end)
        if self.centre is None:
            along = (end - start) / np.linalg.norm(end - start)
            return start + share * (end - start), np.array([along[1], -along[0]])
        centre = np.array(self.centre)
        first, last = (math.atan2(p[0] - centre[0], p[1] - centre[1]) for p in (start, end))
        turn = (last - first + math.pi) % (2 * math.pi) - math.pi
        angle = first + share * turn
        out = np.array([math.sin(angle), math.cos(angle)])
        return centre + np.linalg.norm(start - centre) * out, out if self.convex else -out

    @property
    def touched(self) -> bool:
        """Whether it is measured: an arc by a stylus of its own, a line where a ball has room."""
        room = self.centre is not None or math.dist(self.start, self.end) >= LEAST_MM
        return self.edge is not None and room

    @property
    def toml(self) -> str:
        """As a job spells it."""
        arc = "" if self.centre is None else f", centre = {list(self.centre)}, turn = '{self.turn}'"
        return f"  {{ name = '{self.name}', to = {list(self.end)}{arc} }},"

    @property
    def turn(self) -> str:
        return "convex" if self.convex else "concave"


Place: TypeAlias = tuple[float, float]
Drawn: TypeAlias = tuple[Any, ...]
"""Name, end, the centre of an arc, and the edge."""


def drawn(start: tuple[float, float], *features: Drawn) -> list[Piece]:
    """A profile: name, where it ends, the centre of an arc, and the edge that cuts it.

    An arc whose centre is inside of the material, on the right of the way, is convex.
    """
    pieces = []
    for name, end, *centres, edge in features:
        centre = centres[0] if centres else None
        convex = False
        if centre is not None:
            (x0, z0), (x1, z1) = start, end
            # z is to the right and x up: the centre is on the right of the chord where this cross product is negative
            convex = (z1 - z0) * (centre[0] - x0) - (x1 - x0) * (centre[1] - z0) < 0
        pieces.append(Piece(name, start, end, centre, convex, edge))
        start = end
    return pieces


@dataclass(frozen=True)
class Erring:
    """An edge that stands off by (dx, dz) mm, x a radius, and whose nose is smaller than was said by `smaller_mm`.

    It was set by where it touches along x and z, so that its centre is nearer to the part by that, along both; a face
    at n is cut deeper by smaller (|nx| + |nz|) and less by smaller: e = n·o − smaller (|nx| + |nz| − 1).
    """

    off_mm: tuple[float, float]
    smaller_mm: float = 0.0

    def error_mm(self, normal: Array) -> float:
        """Positive where material is left on."""
        return float(normal @ np.array(self.off_mm) - self.smaller_mm * (np.sum(np.abs(normal)) - 1.0))


def touches_csv(profile: Sequence[Piece], erring: Mapping[Key, Erring], noise_um: float = 0.1) -> str:
    """Three touches a line, five an arc, on all that is touched; noise of either sign by turns."""
    rows = ["point,feature,nominal_x_mm,nominal_z_mm,error_um"]
    for piece in profile:
        if piece.edge is None or not piece.touched:
            continue
        count = 3 if piece.centre is None else 5
        for k in range(count):
            (x, z), normal = piece.at((k + 0.5) / count)
            error_um = 1e3 * erring[piece.edge].error_mm(normal) + noise_um * (-1) ** len(rows)
            rows.append(f"{len(rows)},{piece.name},{x:.9f},{z:.9f},{error_um:.4f}")
    return "\n".join(rows) + "\n"


@dataclass(frozen=True)
class Move:
    """One block that moves, as it stands: its line, motion 0 to 3, the edge in force, ends and an arc's centre."""

    line: int
    motion: int
    edge: Key
    start: tuple[float, float]
    end: tuple[float, float]
    centre: tuple[float, float] | None

    def points(self, step_mm: float = 0.01) -> Array:
        """Points along it, (n, 2)."""
        start, end = np.array(self.start), np.array(self.end)
        if self.centre is None or self.motion < 2:
            return np.linspace(start, end, max(2, int(np.linalg.norm(end - start) / step_mm)))
        centre = np.array(self.centre)
        radii = [np.linalg.norm(p - centre) for p in (start, end)]
        first, last = (math.atan2(p[0] - centre[0], p[1] - centre[1]) for p in (start, end))
        way = 1 if self.motion == 2 else -1  # seen with z to the right and x up, G02 is clockwise: from x towards z
        turn = way * (((last - first) * -way) % (2 * math.pi)) * -1
        share = np.linspace(0.0, 1.0, max(9, int(abs(turn) * radii[0] / (step_mm / 10))))
        angle, radius = first + share * turn, radii[0] + share * (radii[1] - radii[0])
        return np.asarray(centre + np.column_stack([radius * np.sin(angle), radius * np.cos(angle)]))


def moves_of(text: str, unit_mm: float = 1.0, skip: str = r"^$") -> Iterator[Move]:
    """The moves of a lathe program in the order of its blocks: X a diameter, I and K from the arc's start, R a radius.

    Comments in parentheses and blocks that match `skip` are passed over.
    """
    motion, edge, place = 0, (0, 0), (math.nan, math.nan)
    for line, whole in enumerate(text.splitlines(), 1):
        block = re.sub(r"\(.*?\)", "", whole).strip()
        if not block or re.search(skip, block) or re.match(r"[$%;]|V|NA[TG]", block):
            continue
        words = [(letter, float(value)) for letter, value in WORD.findall(block)]
        named = dict(words)
        if "T" in named:
            edge = (int(named["T"]) % 100 if named["T"] >= 100 else int(named["T"]), 1)
        edge = (int(named.get("TG", edge[0])), int(named.get("OG", edge[1])))
        codes = [value for letter, value in words if letter == "G"]
        motion = next((int(code) for code in codes if code in (0, 1, 2, 3)), motion)
        if not {"X", "Z"} & set(named) or any(code in (4, 28, 50, 53, 71, 72, 73, 74, 75, 76) for code in codes):
            continue
        end = (
            named["X"] / 2 * unit_mm if "X" in named else place[0],
            named["Z"] * unit_mm if "Z" in named else place[1],
        )
        centre = None
        if motion >= 2 and "R" in named:
            centre = _centre(place, end, named["R"] * unit_mm, motion)
        elif motion >= 2:
            centre = (place[0] + named.get("I", 0.0) * unit_mm, place[1] + named.get("K", 0.0) * unit_mm)
        yield Move(line, motion, edge, place, end, centre)
        place = end


def _centre(start: tuple[float, float], end: tuple[float, float], radius: float, motion: int) -> tuple[float, float]:
    """Of an arc of less than half a turn: on the right of the way for G02, on the left for G03."""
    (x0, z0), (x1, z1) = start, end
    chord = math.dist(start, end)
    height = math.sqrt(max(radius**2 - chord**2 / 4, 0.0))
    right = ((z0 - z1) / chord, (x1 - x0) / chord)  # (x, z): on the right of (dz, dx), z to the right and x up
    side = height if motion == 2 else -height
    return ((x0 + x1) / 2 + side * right[0], (z0 + z1) / 2 + side * right[1])


NEAR_MM: Final = 0.06
"""No corrected contour is farther off its drawing."""


def off_nominal_mm(points: Sequence[Array], place: Array, normal: Array) -> float:
    """How far off a path is along the normal through a place, where it goes deepest near there."""
    found = []
    for path in points:
        apart = path - place
        across, along = apart @ np.array([normal[1], -normal[0]]), apart @ normal
        for k in np.flatnonzero(across[:-1] * across[1:] <= 0):
            width = across[k] - across[k + 1]
            share = across[k] / width if width else 0.0
            found.append(along[k] + share * (along[k + 1] - along[k]))
    return float(min(off for off in found if abs(off) < NEAR_MM))


TANGENT: Final = 0.02
"""Sine of the angle below which two pieces are meant to be tangent, as coordinates in micrometres say it."""


def inset(path: Sequence[Piece], by_mm: float) -> list[Piece]:
    """The contour that a nose of that radius leaves along a path of its centre: each piece moved in, and cut anew.

    Ends are where neighbouring lines and circles meet, found by Newton's method from the old corner moved in.
    """
    joints = [_moved_in(path[0], 0.0, by_mm)]
    for before, after in pairwise(path):
        place = (_moved_in(before, 1.0, by_mm) + _moved_in(after, 0.0, by_mm)) / 2
        n0, n1 = before.at(1.0)[1], after.at(0.0)[1]
        tangent = abs(n0[0] * n1[1] - n0[1] * n1[0]) < TANGENT
        for _ in range(0 if tangent else 50):
            (f, df), (g, dg) = (_off(piece, place, by_mm) for piece in (before, after))
            place = place - np.linalg.solve(np.array([df, dg]), np.array([f, g]))
        joints.append(place)
    joints.append(_moved_in(path[-1], 1.0, by_mm))
    ends = [(float(x), float(z)) for x, z in joints]
    return [replace(piece, start=a, end=b) for piece, a, b in zip(path, ends[:-1], ends[1:], strict=True)]


def _moved_in(piece: Piece, share: float, by_mm: float) -> Array:
    point, normal = piece.at(share)
    return np.asarray(point - by_mm * normal)


def _off(piece: Piece, place: Array, by_mm: float) -> tuple[float, Array]:
    """How far a point is off a piece moved in, and the gradient of that."""
    if piece.centre is None:
        point, normal = piece.at(0.0)
        return float((place - point) @ normal) + by_mm, normal
    centre, start = np.array(piece.centre), np.array(piece.start)
    radius = float(np.linalg.norm(start - centre)) - (by_mm if piece.convex else -by_mm)
    apart = place - centre
    return float(np.linalg.norm(apart)) - radius, apart / np.linalg.norm(apart)


def clearance_mm(profile: Sequence[Piece], place: tuple[float, float]) -> float:
    """Distance of a point from the drawn profile."""
    points = np.array([piece.at(share)[0] for piece in profile for share in np.linspace(0.0, 1.0, 201)])
    return float(np.min(np.linalg.norm(points - np.array(place), axis=1)))


def job(folder: Path, profile: Sequence[Piece], erring: Mapping[Key, Erring], tables: str) -> Path:
    """A job with this profile and these touches beside it; `tables` are those of tools, programs and compensation."""
    features = "\n".join(piece.toml for piece in profile)
    alone = "\n".join(f"[feature.{piece.name}]\ntool = 0" for piece in profile if piece.edge is None)
    (folder / "touches.csv").write_text(touches_csv(profile, erring))
    (folder / "job.toml").write_text(
        f'[part]\nname = "by hand"\nstart = {list(profile[0].start)}\nfeature = [\n{features}\n]\n'
        f'[gauging]\ntouches = "touches.csv"\n{alone}\n{tables}'
    )
    return folder / "job.toml"
