"""What of a program cuts each feature: the tool, whether its radius and length stand at the control, the work offset
and the direction, from the passes over the feature's walls.

The last pass that touches a wall is the finishing one. Under G41 and G42 it runs on the wall, or, where D holds wear
alone, a radius of the cutter away from it; otherwise a radius away. A radius that is not stated is at most the
smallest distance at which the tool passes within a bore or slot.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Point
from trueloop.milled.feature import ALONG, INSIDE, ROUND, MilledFeature, Side
from trueloop.milled.passes import MATCH_MM, SAME_MM, Called, Passes, Touch
from trueloop.nc.program.called import offset_name, offset_number
from trueloop.wording import wording

NEAR_MM: Final = 1.0
"""A contour that lies so near a wall is meant to be that wall."""
LARGEST_CUTTER_MM: Final = 50.0
"""A path further away than this is of another wall, whatever the cutter."""
SWAPPED: Final = {"bore": "boss", "boss": "bore", "slot": "rib", "rib": "slot", "face": "face on the other side"}


@dataclass(frozen=True)
class StatedCut:
    """What a job states of a feature's cut, None where it leaves that to the program."""

    tool: int | None = None
    work_offset: str | None = None
    side: Side | None = None


@dataclass(frozen=True)
class Registers:
    """The numbers of a tool's registers at the control, of those that its cuts call."""

    radius: tuple[int, ...]
    length: tuple[int, ...]


class CutBy:
    """The passes of a program, asked feature by feature. `radius_mm`: cutters' radii, by tool, as far as stated."""

    def __init__(self, passes: Passes, dialect: str, radius_mm: Mapping[int, float]) -> None:
        """Takes the passes as they are; `resolved` looks at the features."""
        self.passes, self.dialect, self.radius_mm = passes, dialect, dict(radius_mm)
        self.stated = frozenset(radius_mm)
        self.most_mm = dict[int, float]()  # by tool: the least distance at which its centre passes a wall
        self.on_contour = set[int]()  # tools whose register holds the whole radius: some contour of theirs is a wall

    def resolved(self, features: Sequence[tuple[MilledFeature, StatedCut]]) -> list[tuple[MilledFeature, int | None]]:
        """Returns the features with what cuts them, and the line of each one's last pass, None where the program does
        not cut it and the job states what does.

        Raises MIL-CUT, MIL-NOT-CUT, MIL-SIDE, MIL-LEVELS and MIL-STATED.
        """
        walls = [self._walls(feature) for feature, _ in features]
        self._imply_radii([feature for feature, _ in features], walls)
        return [self._one(*one, touches) for one, touches in zip(features, walls, strict=True)]

    def registers(self, tool: int) -> Registers:
        """Returns the registers by which a tool is called. Raises MIL-REGISTER for one that another tool calls, too."""
        found = dict[str, list[int]]()
        for register, letter in (("radius", "D"), ("length", "H")):
            users = self.passes.users(register)
            own = sorted(number for number, tools in users.items() if tool in tools)
            for number in own:
                if len(users[number]) > 1:
                    tools = sorted(users[number])
                    raise Code.MIL_REGISTER.refusal(
                        f"{letter}{number} holds the {register} of tools {' and '.join(map(str, tools))}: a number "
                        f"entered for tool {tool} would move what the other cuts",
                        hint=f"call each tool's {register} by a register of its own",
                        values={"register": f"{letter}{number}", "tools": tools},
                    )
            found[register] = own
        return Registers(tuple(found["radius"]), tuple(found["length"]))

    def _walls(self, feature: MilledFeature) -> list[list[Touch]]:
        """Returns the passes over each wall, whatever their distance; of a face that looks up, none."""
        x, y, top = feature.place_mm
        half_way = top - 0.5 * feature.depth_mm
        if feature.kind in ROUND:
            return [self.passes.around((x, y), 0.5 * feature.size_mm, feature.inward, half_way)]
        i, j, up = feature.direction
        if feature.kind == "face":
            return [self.passes.along((x, y), (i, j), half_way)] if abs(up) < 1.0 - ALONG else []
        found = list[list[Touch]]()
        for sign in (1.0, -1.0):
            wall: Point = (x + sign * i * 0.5 * feature.size_mm, y + sign * j * 0.5 * feature.size_mm)
            out = -sign if feature.inward else sign
            found.append(self.passes.along(wall, (out * i, out * j), half_way))
        return found

    def _imply_radii(self, features: Sequence[MilledFeature], walls: Sequence[Sequence[Sequence[Touch]]]) -> None:
        """Notes radii of cutters that are not stated. Raises MIL-STATED for a stated one that is too large.

        Passes along walls imply them first: where one lies on the wall of a bore, a plunge on the bore's axis shows no
        radius. It may be of a smaller drill that went through afterwards, or the way in.
        """
        stated, implied = dict(self.radius_mm), dict[int, float]()
        for plunging in (False, True):
            for feature, each in zip(features, walls, strict=True):
                touches = [touch for wall in each for touch in wall]
                shown = feature.kind in INSIDE and not (plunging and self._round(touches))
                for touch in touches:
                    if (touch.climb is None) is plunging:
                        self._imply_radius(feature, touch, stated, implied if shown else {})
            self.radius_mm = {**implied, **stated}

    def _imply_radius(
        self, feature: MilledFeature, touch: Touch, stated: Mapping[int, float], implied: dict[int, float]
    ) -> None:
        tool, least = touch.called.tool, stated.get(touch.called.tool)
        if touch.compensated and touch.from_air and abs(touch.gap_mm) <= MATCH_MM:
            self.on_contour.add(tool)
        if touch.compensated or not MATCH_MM < touch.gap_mm <= LARGEST_CUTTER_MM:
            return
        if least is not None and touch.gap_mm < least - MATCH_MM:
            raise Code.MIL_STATED.refusal(
                f"`cutter_radius` of tool {tool} is {least:g} mm, and line {touch.line} leads its centre past "
                f"the wall of {feature.name} at {touch.gap_mm:.3f} mm",
                hint="state the radius, not the diameter; or correct place and size of the feature",
                values={"stated": least, "program": touch.gap_mm},
            )
        self.most_mm[tool] = min(touch.gap_mm, self.most_mm.get(tool, touch.gap_mm))
        if touch.gap_mm <= 0.5 * feature.size_mm + MATCH_MM:
            implied[tool] = min(touch.gap_mm, implied.get(tool, touch.gap_mm))

    def _round(self, touches: Sequence[Touch]) -> set[int]:
        """Returns the tools that a pass along a wall, other than a plunge, leads so that they touch it."""
        return {
            touch.called.tool
            for touch in touches
            if touch.climb is not None and touch.from_air and self._touches(touch)
        }

    def _one(
        self, feature: MilledFeature, stated: StatedCut, walls: Sequence[Sequence[Touch]]
    ) -> tuple[MilledFeature, int | None]:
        if walls:
            last = [self._last(feature, stated, touches) for touches in walls]
        elif feature.direction[2] > 0.0:
            last = [self._last_at_level(feature, stated)]
        else:
            last = [None]
        found = [touch for touch in last if touch is not None]
        self._require_seen(feature, stated, found if len(found) == len(last) else [])
        if len(found) < len(last):
            if stated.tool is None:
                raise self._not_cut(feature, walls)
            return feature, None
        called = found[0].called
        if called.tool < 0:
            why = "its tool is called by a name, or before any T word"
            raise _cut(feature, why, "leave [program] out, and state `tool` of each feature, and each [[tool]]", found)
        if found[-1].called != called:
            names = " and ".join(self._words(touch) for touch in found)
            raise _cut(feature, f"its walls are cut by {names}", "make two faces of it", found)
        if self.passes.sets_work_offset(found[-1].move):
            name = offset_name(called.work_offset, self.dialect)
            raise Code.MIL_SET.refusal(
                f"{feature.name} is cut from {name}, which the program sets itself before line {found[-1].line}: "
                "numbers entered in it at the control are overwritten in every run",
                hint=f"take the block that sets {name} out of the program, and enter its values at the control",
                place=Place(line=found[-1].line),
                values={"work_offset": name},
            )
        sides = {None if touch.climb is None else touch.climb for touch in found}
        side: Side = "" if len(sides) > 1 or None in sides else "climb" if True in sides else "conventional"
        name = offset_name(called.work_offset, self.dialect)
        for key, own, program in (
            ("tool", stated.tool, called.tool),
            ("work_offset", stated.work_offset, name),
            ("side", stated.side or None, side),
        ):
            same = own == program or (key == "work_offset" and self._same_offset(str(own), called))
            if own is not None and not same:
                raise Code.MIL_STATED.refusal(
                    f"`{key}` of {feature.name} is {own!r}, and line {found[-1].line}, the last that cuts it, runs "
                    f"with {program!r}",
                    hint=f"leave `{key}` out of its table [[feature]], or correct its place and size there",
                    place=Place(line=found[-1].line),
                    values={"stated": own, "program": program},
                )
        cut = replace(
            feature,
            tool=called.tool,
            work_offset=stated.work_offset or name,  # the same one, under the name that records have it
            side=side,
            radius_at_control=found[0].compensated,
            length_at_control=(called.length > 0) * (-1 if called.subtracted else 1),
        )
        return cut, max(touch.line for touch in found)

    def _require_seen(self, feature: MilledFeature, stated: StatedCut, touches: Sequence[Touch]) -> None:
        """Raises MIL-CUT where a macro or a cycle that the path does not show could have cut a feature last."""
        after = min((touch.move for touch in touches), default=-1)
        for point in feature.surface()[0]:
            line = self.passes.hidden_after(after, point)
            if line is not None and stated.tool is None:
                raise Code.MIL_CUT.refusal(
                    f"what cuts {feature.name} is not plain: line {line} runs what the path does not show, and that "
                    "could cut there last",
                    hint="state the feature's `tool` and `work_offset`, and the [[tool]] with `radius`",
                    place=Place(line=line),
                    values={"feature": feature.name},
                )

    def _same_offset(self, stated: str, called: Called) -> bool:
        return offset_number(stated) == called.work_offset

    def _last(self, feature: MilledFeature, stated: StatedCut, touches: Sequence[Touch]) -> Touch | None:
        """Returns the last pass that touches a wall; None without."""
        beside = [touch for touch in touches if touch.from_air and touch.gap_mm >= -MATCH_MM]
        touching = [touch for touch in beside if self._touches(touch)]
        narrow = self._round(touching)  # their own plunges in the middle do not reach the wall
        unsure = [
            touch
            for touch in beside
            if self._may_touch(touch) and (touch.climb is not None or touch.called.tool not in narrow)
        ]
        if not touching and not unsure:
            self._require_side(feature, touches)
            return None
        last = self._last_of(feature, stated, touching, unsure)
        off = [touch for touch in touches if touch.move > last.move and touch.compensated and not self._touches(touch)]
        if any(abs(touch.gap_mm) <= NEAR_MM for touch in off):  # the finishing pass cuts another size
            raise self._not_cut(feature, [off])
        return last

    def _may_touch(self, touch: Touch) -> bool:
        """Returns whether a pass could touch a wall, by a radius that is neither stated nor implied."""
        tool = touch.called.tool
        known = tool in (self.on_contour if touch.compensated else self.radius_mm)
        most = self.most_mm.get(tool, LARGEST_CUTTER_MM) + MATCH_MM
        return not known and tool not in self.stated and MATCH_MM < touch.gap_mm <= most

    def _last_of(
        self, feature: MilledFeature, stated: StatedCut, touching: Sequence[Touch], unsure: Sequence[Touch]
    ) -> Touch:
        """Returns the last of passes. Raises MIL-CUT where it is not plain which that is."""
        if not touching and len({touch.called for touch in unsure}) == 1:
            touching, unsure = unsure, []
        after = max((touch.move for touch in touching), default=-1)
        known = {touch.called for touch in touching if touch.move == after}
        later = [touch for touch in unsure if touch.move > after and touch.called not in known]
        if later:
            tools = sorted({touch.called.tool for touch in later})
            why = f"{self._words(later[-1])} passes there, and it is not known whether it reaches"
            radii = " ".join(f"--tool {tool}=R…" for tool in tools)
            hint = (
                f"state `cutter_radius` of tool {' and '.join(map(str, tools))} in its [[tool]], {radii} of `mill new`"
            )
            raise _cut(feature, why, hint, [*touching, *later])
        offsets = {touch.called.work_offset for touch in touching}
        if stated.work_offset is not None:
            touching = [touch for touch in touching if self._is(stated.work_offset, touch)] or touching
        elif len(offsets) > 1:
            names = " and ".join(offset_name(number, self.dialect) for number in sorted(offsets))
            raise _cut(
                feature,
                f"a wall at that place is cut from {names}",
                "state `work_offset` in its table [[feature]]",
                touching,
            )
        return max(touching, key=lambda touch: touch.move)

    def _is(self, stated: str, touch: Touch) -> bool:
        name = offset_name(touch.called.work_offset, self.dialect)
        return stated == name or self._same_offset(stated, touch.called)

    def _touches(self, touch: Touch) -> bool:
        on_wall = touch.compensated and abs(touch.gap_mm) <= MATCH_MM
        tool = touch.called.tool
        radius = self.radius_mm.get(tool) if tool in self.stated or not touch.compensated else None
        return on_wall or (radius is not None and abs(touch.gap_mm - radius) <= MATCH_MM)

    def _last_at_level(self, feature: MilledFeature, stated: StatedCut) -> Touch | None:
        """Returns the last pass over a face that looks up. Raises MIL-LEVELS where there are several heights."""
        passes, (x, y, z) = self.passes, feature.place_mm
        moves = passes.at_level(z)
        over = [
            Touch(
                move=move,
                line=int(passes.path.line[move]),
                called=passes.called(move),
                gap_mm=0.0,
                compensated=passes.compensated(move),
                climb=None,
                from_air=True,
            )
            for move in moves.tolist()
        ]
        covers = [
            touch
            for touch in over
            if (radius := self.radius_mm.get(touch.called.tool)) is not None
            and passes.distance_mm(touch.move, (x, y)) <= (2.0 * radius if touch.compensated else radius) + MATCH_MM
        ]
        unsure = [touch for touch in over if touch.called.tool not in self.radius_mm]
        if not covers and len({touch.called for touch in over}) == 1:
            covers, unsure = over, []
        heights = sorted({round(float(passes.end_mm[cover.move, 2]), 6) for cover in (*covers, *unsure)})
        if heights and heights[-1] - heights[0] > SAME_MM:
            raise Code.MIL_LEVELS.refusal(
                f"{feature.name} at z {z:g} mm is cut at {len(heights)} levels, {heights[0]:g} to {heights[-1]:g} mm",
                hint="state two faces, each at its level and at a place that one pass covers alone",
                place=Place(line=over[-1].line),
                values={"feature": feature.name, "levels_mm": heights},
            )
        return self._last_of(feature, stated, covers, unsure) if covers or unsure else None

    def _words(self, touch: Touch) -> str:
        return f"tool {touch.called.tool} ({offset_name(touch.called.work_offset, self.dialect)}, line {touch.line})"

    def _require_side(self, feature: MilledFeature, touches: Sequence[Touch]) -> None:
        """Raises MIL-SIDE where a pass runs where the wall is, with its tool where the material is stated to be."""
        wrong = [touch for touch in touches if not touch.from_air or touch.gap_mm < -MATCH_MM]
        behind = list[Touch]()
        for touch in wrong:
            radius = self.radius_mm.get(touch.called.tool)
            centre = not touch.compensated and radius is not None and abs(touch.gap_mm + radius) <= MATCH_MM
            if abs(touch.gap_mm) <= MATCH_MM or centre:
                behind.append(touch)
        if behind:
            raise Code.MIL_SIDE.refusal(
                f"{feature.name} is stated as a {feature.kind}, and line {behind[-1].line} leads tool "
                f"{behind[-1].called.tool} along its wall on the other side",
                hint=f'in its table [[feature]] `kind = "{SWAPPED[feature.kind]}"`, or another place or size',
                place=Place(line=behind[-1].line),
                values={"feature": feature.name, "kind": feature.kind},
            )

    def _not_cut(self, feature: MilledFeature, walls: Sequence[Sequence[Touch]]) -> TrueloopError:
        x, y, z = feature.place_mm
        beside = [touch for touches in walls for touch in touches if not self._touches(touch)]
        near = min(beside, key=lambda touch: abs(touch.gap_mm), default=None)
        nearest = "" if near is None else f"; the nearest, {self._words(near)}, is {near.gap_mm:+.3f} mm from the wall"
        return Code.MIL_NOT_CUT.refusal(
            wording(
                "no pass of the program cuts {feature}, a {kind} at x {x:g}, y {y:g}, z {z:g} mm{nearest}",
                feature=feature.name,
                kind=feature.kind,
                x=x,
                y=y,
                z=z,
                nearest=nearest,
            ),
            hint="correct its place and size, state `cutter_radius` in a [[tool]] where D holds wear alone, or state "
            "`tool` and `work_offset` where another program cuts it",
            values={"feature": feature.name},
        )


def _cut(feature: MilledFeature, why: str, hint: str, touches: Sequence[Touch]) -> TrueloopError:
    return Code.MIL_CUT.refusal(
        wording("what cuts {feature} is not plain: {why}", feature=feature.name, why=why),
        hint=hint,
        place=Place(line=touches[-1].line),
        values={"feature": feature.name},
    )
