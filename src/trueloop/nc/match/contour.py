"""The nominal profile from a finish program: the path of the nose centre less the nose radius. No drawing needed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.curve import Curve, part_of
from trueloop.geometry.feature import Feature, Line, LineOrArc
from trueloop.geometry.intersection import intersections
from trueloop.geometry.offset import contour_from_centre_path
from trueloop.geometry.profile import SQUARE, Profile, Side, junctions_of, named_by_kind
from trueloop.geometry.validate import GAP_MM, checked_profile, runs_as
from trueloop.nc.match.cutters import SidesOfCuts
from trueloop.nc.program.along import FeedMove, moves_of_one_kind
from trueloop.nc.program.tool_path import NO_COMPENSATION
from trueloop.wording import wording

_AXIS: Final = Line("axis", (0.0, 0.0), (0.0, 1.0))
_OUTWARDS: Final = math.sin(math.radians(5.0))


@dataclass(frozen=True)
class ProgramContour:
    """A profile read from a program, the program's line behind each feature, and every decision in words."""

    profile: Profile
    lines: tuple[int, ...]
    notes: tuple[str, ...]


def contour_of_program(
    moves: Sequence[FeedMove],
    nose_radius_mm: float,
    *,
    lines: tuple[int, int] | None = None,
    side: Side = Side.OUTSIDE,
    shown: SidesOfCuts = SidesOfCuts(),  # noqa: B008 - a frozen value
    tip: int = 0,
) -> ProgramContour:
    """Reads the contour that a finish pass leaves from the path of the nose's centre or, under G41 and G42, of itself.

    Features are named cylinder-1, cone-1, arc-1… from chuck end to free end, of a bore (`side`) from free end to chuck.
    Without `lines` (from–to, both included) the pass is the uninterrupted chain of feed moves with the most moves, the
    last one of equals; straight moves at its ends that come in from outside or leave outwards, by a concave corner of
    more than 45°, are taken for the ways in and out; of a bore those that come from the axis and go back to it. With
    `lines` all feed moves of that range count. What lies beyond the spindle axis is always cut off. The notes state
    what was left out.
    `tip`: the orientation of the tip whose path the program states, 0 for the nose's centre; `moves` are the centre's.
    `shown` is what the rapid moves show of the side (`rapid.sides_of_cuts`). Raises NC-NO-CONTOUR where no feed moves
    are left, NC-BORE where G41, G42 or `shown` contradict the side, and the GEO errors of a contour that cannot be.
    """
    found = [m for m in moves if m.path.length_mm > GAP_MM]
    chain, notes = _chain(found, lines)
    chain, offset_mm = moves_of_one_kind(chain, nose_radius_mm)
    if offset_mm != nose_radius_mm:
        notes.append(wording("The pass is the contour itself: the control keeps the nose off it by G41 or G42."))
    elif nose_radius_mm > 0:
        point = wording("the tip of orientation {tip}", tip=tip) if tip else wording("the nose's centre")
        notes.append(
            wording(
                "Without G41 or G42 the pass was taken for the path of {point}, and the contour for what the nose of "
                "{nose:.4f} mm leaves along it. Where the program moves another point, sizes of this part are wrong by "
                "up to twice the radius: state the orientation of the tip, and where it moves the contour itself, do "
                "not use it.",
                point=point,
                nose=nose_radius_mm,
            )
        )
    ordered = _material_on_the_right(chain, side)
    if ordered is not chain:
        notes.append(
            wording("The program cuts away from the chuck: its moves were put in the opposite order.")
            if side is Side.INSIDE
            else wording("The program cuts towards the chuck: its moves were put in the opposite order.")
        )
    _require_side(chain, ordered is not chain, side, shown)
    chain = ordered
    if lines is None:
        chain = _without_approach(chain, side, offset_mm, notes)
    chain = _up_to_axis(chain, notes)
    if not chain:
        raise _nothing(len(found), lines)
    line_of = {_name(move): move.line for move in chain}
    contour = contour_from_centre_path([_rounded_off(move) for move in chain], offset_mm)
    features = _cut_at_axis(contour, notes)
    about_edges = [line for name, line in line_of.items() if name not in {feature.name for feature in contour}]
    notes += [wording("Line {line} only turns the nose about an edge: no feature.", line=line) for line in about_edges]
    profile = checked_profile(named_by_kind(features), side=side)
    notes.append(
        wording(
            "{count} features, nose radius {nose:.4f} mm: {names}.",
            count=len(features),
            nose=nose_radius_mm,
            names=", ".join(profile.names),
        )
    )
    return ProgramContour(profile, tuple(line_of[feature.name] for feature in features), tuple(notes))


def _chain(moves: Sequence[FeedMove], lines: tuple[int, int] | None) -> tuple[list[FeedMove], list[str]]:
    if lines is not None:
        chosen = [m for m in moves if lines[0] <= m.line <= lines[1]]
        first, last = lines
        return chosen, [
            wording("Lines {first}–{last} were named: {count} feed moves.", first=first, last=last, count=len(chosen))
        ]
    chains = [list(members) for _, members in groupby(moves, key=lambda m: m.chain)]
    if not chains:
        return [], []
    longest = max(map(len, chains))
    chosen = [chain for chain in chains if len(chain) == longest][-1]
    return chosen, [
        wording(
            "Lines {first}–{last} were taken: {count} feed moves, the longest uninterrupted chain of {chains}, the "
            "last of equals.",
            chains=len(chains),
            first=chosen[0].line,
            last=chosen[-1].line,
            count=len(chosen),
        )
    ]


def _material_on_the_right(moves: list[FeedMove], side: Side) -> list[FeedMove]:
    """The moves in the order of the profile: as they are, or all of them run backwards.

    Around a part only G41 and G42 show which it is.
    """
    forwards = runs_as(side, moves[0].path.start_mm, moves[-1].path.end_mm, GAP_MM) if moves else True
    if side is Side.AROUND and moves:
        if moves[0].compensation == NO_COMPENSATION:
            raise Code.NC_BORE.refusal(
                wording(
                    "on which side of the pass of line {line} the material is does not follow from the program",
                    line=moves[0].line,
                ),
                hint="give the features around the part in the job, material on the right, or correct outside and bore "
                "as two parts",
                place=Place(line=moves[0].line),
            )
        forwards = moves[0].compensation == 41
    if forwards:
        return moves
    return [replace(move, path=move.path.reversed()) for move in reversed(moves)]


def _require_side(moves: Sequence[FeedMove], backwards: bool, side: Side, shown: SidesOfCuts) -> None:
    """Taken for the other side, every error of a contour had the wrong sign."""
    keeps_off = 42 if backwards else 41
    contradicted = shown.boring if side is Side.OUTSIDE else shown.turning if side is Side.INSIDE else frozenset()
    for move in moves:
        if move.compensation not in (NO_COMPENSATION, keeps_off):
            why = f"G{move.compensation} keeps the nose on the other side"
        elif not move.on_contour and move.index in contradicted:
            why = f"rapid moves beside it and after it are {_BESIDE[side]}"
        else:
            continue
        raise Code.NC_BORE.refusal(
            wording("the pass of line {line} is no {cut}: {why}", line=move.line, cut=_PASS[side], why=why),
            hint='state `part.side`, "outside" or "inside" (--side): signs of errors depend on it. '
            f"Here that side wants G{keeps_off}",
            place=Place(line=move.line),
        )


_PASS: Final = {Side.OUTSIDE: "pass outside", Side.INSIDE: "bore", Side.AROUND: "pass around the part"}
_BESIDE: Final = {Side.OUTSIDE: "nearer to the axis", Side.INSIDE: "further from the axis"}


def _without_approach(moves: list[FeedMove], side: Side, offset_mm: float, notes: list[str]) -> list[FeedMove]:
    """Leaves out a way in or out: straight moves at the ends that make a concave corner of more than 45° with the rest.

    At the chuck end one that runs straight from or to the side where the tool is free, at the free end one that goes
    there in any direction, or lies in front of the face at z = 0 beyond which nothing else is cut: along z by whatever
    corner.
    """
    kept = list(moves)
    if side is Side.AROUND:
        return kept
    first_end, last_end = ("chuck", "free") if side is Side.OUTSIDE else ("free", "chuck")
    free_x = 1.0 if side is Side.OUTSIDE else -1.0
    for end, at, pair, along in ((first_end, 0, slice(2), -1.0), (last_end, -1, slice(-2, None), 1.0)):
        if len(kept) < 2 or not isinstance(kept[at].path, Line):
            continue
        to_free, leaves = free_x * along * float(kept[at].path.tangent(0.0)[0]), _leaves(kept[pair])
        in_air = end == "free" and _in_front(kept[at], kept[1:] if at == 0 else kept[:-1], offset_mm)
        in_air &= leaves or _is_along_z(kept[at])
        if in_air or (leaves and to_free > (SQUARE if end == "chuck" else _OUTWARDS)):
            line = kept.pop(at).line
            if end == "chuck":
                note = wording(
                    "Line {line} was taken for the way in or out at the chuck end, not for a face.", line=line
                )
            elif in_air:
                note = wording(
                    "Line {line} was taken for the way in or out at the free end, not for a cylinder.", line=line
                )
            else:
                note = wording(
                    "Line {line} was taken for the way in or out at the free end, not for a cone.", line=line
                )
            notes.append(note)
    return kept


def _leaves(pair: Sequence[FeedMove]) -> bool:
    return junctions_of([member.path for member in pair])[0].turn_rad < -math.pi / 4


def _is_along_z(move: FeedMove) -> bool:
    return abs(move.path.end_mm[0] - move.path.start_mm[0]) <= GAP_MM


def _in_front(move: FeedMove, others: Sequence[FeedMove], offset_mm: float) -> bool:
    """Returns whether a move is in the air in front of the part's face at z = 0; `offset_mm`: of moves from contour."""
    beyond_mm = min(move.path.start_mm[1], move.path.end_mm[1]) - offset_mm
    highest_mm = max(max(other.path.start_mm[1], other.path.end_mm[1]) for other in others) - offset_mm
    outside_axis = move.path.start_mm[0] > GAP_MM
    return outside_axis and abs(beyond_mm) <= GAP_MM and abs(highest_mm) <= GAP_MM


def _up_to_axis(moves: list[FeedMove], notes: list[str]) -> list[FeedMove]:
    """Leaves out what starts at or beyond the axis, at the free end."""
    kept = list(moves)
    while kept and kept[-1].path.start_mm[0] <= GAP_MM:
        notes.append(
            wording("Line {line} was left out: it starts at or beyond the spindle axis.", line=kept.pop().line)
        )
    return kept


def _name(move: FeedMove) -> str:
    """Names the move in a message about its geometry: a cycle has several moves in one line."""
    return f"line {move.line}, move {move.index}"


def _rounded_off(move: FeedMove) -> LineOrArc:
    """The move's shape under its name; an arc's centre moved so that both its ends lie on one circle.

    Programs round end and centre separately; the centre goes along the chord by half of (r_end² − r_start²) / chord.
    """
    path = replace(move.path, name=_name(move))
    if isinstance(path, Line):
        return path
    start, end, centre = (np.asarray(p) for p in (path.start_mm, path.end_mm, path.centre_mm))
    chord = end - start
    along = (float((end - centre) @ (end - centre)) - float((start - centre) @ (start - centre))) / float(chord @ chord)
    shift = along / 2 * chord
    if np.linalg.norm(shift) > 10 * GAP_MM:
        return path
    x, z = centre + shift
    moved = replace(path, centre_mm=(float(x), float(z)))
    # Beyond the end by what the old sweep went too far.
    beyond_mm = float(moved.locate(moved.end_mm)[0]) - moved.length_mm
    sweep_rad = moved.sweep_rad + math.copysign(beyond_mm / moved.radius_mm, moved.sweep_rad)
    return replace(moved, sweep_rad=sweep_rad)


def _cut_at_axis(contour: Sequence[Feature], notes: list[str]) -> list[Feature]:
    features = list(contour)
    while features and features[-1].start_mm[0] <= GAP_MM:
        name = features.pop().name.capitalize()
        notes.append(wording("{move}, was left out: it cuts nothing outside the axis.", move=name))
    if features and features[-1].end_mm[0] < -GAP_MM:
        last = features[-1]
        end = min(intersections(last, _AXIS), key=lambda p: abs(float(last.locate(p)[0]) - last.length_mm))
        features[-1] = _ended(last, (0.0, end[1]))
        name = last.name.capitalize()
        notes.append(wording("{move}, runs beyond the axis: its feature ends at x = 0.", move=name))
    return features


def _ended(feature: Feature, end: tuple[float, float]) -> Feature:
    if isinstance(feature, Line):
        return replace(feature, end_mm=end)
    if isinstance(feature, Curve):
        return part_of(feature, 0.0, float(feature.locate(end)[0]))
    sweep_rad = math.copysign(float(feature.locate(end)[0]) / feature.radius_mm, feature.sweep_rad)
    return replace(feature, end_mm=end, sweep_rad=sweep_rad)


def _nothing(count: int, lines: tuple[int, int] | None) -> TrueloopError:
    where = f"in lines {lines[0]}–{lines[1]}" if lines else "that could be a finish pass"
    return Code.NC_NO_CONTOUR.refusal(
        f"no moves {where} among {count} feed moves", hint="check the range of lines, the dialect and the parameters"
    )
