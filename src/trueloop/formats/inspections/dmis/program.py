"""A DMIS inspection program of a turned part: points with their normals, and diameters of circles.

The part's frame has to be in force: z along the axis, away from the chuck, points turned from x to y. Between touches
the ball is led by GOTO; `SNSET/CLRSRF` is left out, because a retreat along one axis may lead through a collar. From
files and manuals seen: DMISMN, UNITS, MODE, SNSET, FEAT, TOL/DIAM, MEAS, PTMEAS, GOTO/CART, ENDMES, OUTPUT, TEXT/OPER,
ENDFIL. From memory of DMIS 5.2: DISPLY/STOR,DMIS and PRCOMP.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from trueloop.domain.characteristic import Characteristic
from trueloop.formats.inspections.dmis.writing import Labels, comment, number, numbers, quoted, statements_text
from trueloop.probing.cmm_moves import CmmApproach, CmmMove, way_back

NORMAL_DECIMALS = 6


@dataclass(frozen=True)
class MeasuredCircle:
    """A diameter to be measured as a circle of touches at one z; limits are those of the characteristic."""

    characteristic: Characteristic
    z_mm: float
    moves: tuple[CmmMove, ...]


def dmis_program(
    name: str, points: Sequence[CmmMove], circles: Sequence[MeasuredCircle], approach: CmmApproach, source: str
) -> str:
    """Returns the program, in mm. Every point and circle is measured and output, with its tolerance if it has one."""
    labels, lines = Labels(), _heading(name, approach, source)
    for move in points:
        lines += _point(labels.new(move.touch.name), move)
    for circle in circles:
        lines += _circle(labels.new(circle.characteristic.name, "D"), circle)
    moves = [*points, *(move for circle in circles for move in circle.moves)]
    return statements_text([*lines, *(_goto(position) for position in way_back(moves)), "ENDFIL"])


def _heading(name: str, approach: CmmApproach, source: str) -> list[str]:
    return [
        f"DMISMN/{quoted(name)},05.2",
        comment(f"inspection program made by trueloop from {source}"),
        comment("part coordinates: z along the axis away from the chuck, origin as on the drawing, y = 0 at 0 degrees"),
        comment(
            f"moves for a ball of {number(2 * approach.ball_radius_mm)} mm; {number(approach.clearance_mm)} mm stay "
            "free around the part; the stem is not looked at"
        ),
        "UNITS/MM,ANGDEC",
        "DISPLY/STOR,DMIS",
        "TEXT/OPER,'Align the part first: the moves are in its coordinates'",
        "PRCOMP/ON",
        f"SNSET/APPRCH,{number(approach.approach_mm)}",
        f"SNSET/RETRCT,{number(approach.approach_mm)}",
        "MODE/PROG,MAN",
    ]


def _point(label: str, move: CmmMove) -> list[str]:
    place = f"{numbers(move.touch.nominal_mm)},{numbers(move.touch.outward_normal, NORMAL_DECIMALS)}"
    return [
        comment(f"{move.touch.name} on {move.touch.feature}"),
        f"F({label})=FEAT/POINT,CART,{place}",
        *map(_goto, move.way_mm),
        f"MEAS/POINT,F({label}),1",
        f"PTMEAS/CART,{place}",
        "ENDMES",
        f"OUTPUT/FA({label})",
    ]


def _circle(label: str, circle: MeasuredCircle) -> list[str]:
    asked = circle.characteristic
    nominal = asked.nominal
    limits = [number(one - nominal) for one in (asked.lower_limit, asked.upper_limit) if one is not None]
    stated = len(limits) == 2  # DMIS has no word for a limit on one side alone
    touches = [
        line
        for move in circle.moves
        for line in (
            *map(_goto, move.way_mm),
            f"PTMEAS/CART,{numbers(move.touch.nominal_mm)},{numbers(move.touch.outward_normal, NORMAL_DECIMALS)}",
        )
    ]
    return [
        comment(f"{asked.name}: {asked.quantity} of {asked.feature}"),
        f"F({label})=FEAT/CIRCLE,OUTER,CART,0,0,{number(circle.z_mm)},0,0,1,{number(nominal)}",
        *([f"T({label})=TOL/DIAM,{','.join(limits)}"] if stated else []),
        f"MEAS/CIRCLE,F({label}),{len(circle.moves)}",
        *touches,
        "ENDMES",
        f"OUTPUT/FA({label}),TA({label})" if stated else f"OUTPUT/FA({label})",
    ]


def _goto(position: Sequence[float]) -> str:
    return f"GOTO/CART,{numbers(position)}"
