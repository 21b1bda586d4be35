"""The programs of a correction: which tool offsets cut the contour, the contour's program, the variant with tool
offsets alone, written, read back and compared with what was intended, and the offset as numbers.
"""

from collections.abc import Mapping, Set
from dataclasses import dataclass

import numpy as np

from trueloop.domain.proposal import HeldTool
from trueloop.domain.record import ChangedWord
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.part_on_machine import PartOnMachine
from trueloop.loops.turned.paths import Paths
from trueloop.loops.turned.written import Writing, write_contour
from trueloop.nc.edit.changes import changes
from trueloop.nc.edit.edit import Edit
from trueloop.nc.program.called import CalledOffset, called, edge_called, runs_without_offset
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.compensation.decide import Decision
from trueloop.turned.compensation.limits import check_offset
from trueloop.turned.options import By, Options
from trueloop.turned.program.offsets import (
    has_local_shift,
    offset_state,
    require_same_path,
    require_shift,
    require_updates,
    shift_edits,
    shifted_moves,
    tool_offset_updates,
    update_edits,
)
from trueloop.turned.program.read_back import SAME_MM
from trueloop.turned.program.wear_numbers import WearOffset, wear_offset
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import wording


@dataclass(frozen=True)
class ContourTools:
    """Tool offsets by feature, None where the tool has no number; `others`: numbers that cut something else.

    `sharing`: the T words of several tools that run with the offset that cuts the contour.
    """

    calls: tuple[CalledOffset | None, ...]
    others: tuple[int, ...]
    sharing: tuple[int, ...] = ()

    @property
    def cut_by(self) -> tuple[int | None, ...]:
        """Numbers of the offsets by feature."""
        return tuple(None if call is None else call.number for call in self.calls)

    @property
    def several(self) -> bool:
        """Returns whether the contour is cut with more than one offset: then no single one corrects it."""
        return len(set(self.calls)) > 1

    @property
    def notes(self) -> tuple[str, ...]:
        """Returns notes where there are several offsets, or several tools of one."""
        if self.sharing:
            return (
                wording(
                    "{count} tools ({tools}) use offset {number}: it moves what each of them cuts, so that the contour "
                    "is corrected in the program.",
                    count=len(self.sharing),
                    tools=self._sharing_words,
                    number=self.cut_by[0] or 0,
                ),
            )
        if not self.several:
            return ()
        numbers = ", ".join(str(number) for number in sorted({number or 0 for number in self.cut_by}))
        return (
            wording(
                "The contour is cut with the tool offsets {numbers}: it is corrected in the program, since no single "
                "offset moves all of it.",
                numbers=numbers,
            ),
        )

    @property
    def _sharing_words(self) -> str:
        return ", ".join(f"T{word:04d}" for word in self.sharing)

    def by(self, mode: By) -> By:
        """Returns how to correct. Raises NC-OFFSET where an offset is requested of several, or of a shared one."""
        if not self.several and not self.sharing:
            return mode
        if mode == "offset" and self.sharing:
            raise Code.NC_OFFSET.refusal(
                f"{len(self.sharing)} tools ({self._sharing_words}) use offset {self.cut_by[0]}: it moves what each of "
                "them cuts",
                hint="give the finishing tool an offset number of its own, or leave out `compensation.by`",
            )
        if mode == "offset":
            raise Code.NC_OFFSET.refusal(
                f"the contour is cut with {len(set(self.calls))} tool offsets: one of them moves a part of it alone",
                hint='leave out `compensation.by = "offset"`: the contour is corrected then',
            )
        return "contour"


def contour_tools(program: Program, matched: Commanded, alone: bool = False) -> ContourTools:
    """Returns the tools of a finish program matched with its profile; `alone`: others are corrected beside it."""
    path = matched.path

    def of(move: int) -> CalledOffset | None:
        return called(program.dialect, path, move)

    calls = tuple(of(feature.moves[0].move.index) for feature in matched.match.features)
    cutting = np.isin(path.motion, (Motion.LINE, Motion.ARC))
    words, first = np.unique(path.tool[cutting], return_index=True)
    firsts = zip(words.tolist(), np.flatnonzero(cutting)[first].tolist(), strict=True)
    by_word = {word: call for word, move in firsts if (call := of(move)) is not None}
    numbers = {call.number for call in calls if call is not None}
    others = () if alone else tuple(sorted({call.number for call in by_word.values()} - numbers))
    return ContourTools(calls, others, _sharing(program, by_word, set(calls)))


def _sharing(program: Program, by_word: Mapping[int, CalledOffset], calls: Set[CalledOffset | None]) -> tuple[int, ...]:
    """Returns the T words of several tools that cut with the contour's only offset: T0101 and T0201."""
    if not program.dialect.offset_in_t or len(calls) > 1:
        return ()
    words = sorted(word for word, call in by_word.items() if call in calls and word >= 100)
    return tuple(words) if len({word // 100 for word in words}) > 1 else ()


@dataclass(frozen=True)
class Programs:
    """The corrected program, and its variant with `wear` if any; `changes` of the one to run, `notes` before it."""

    corrected: bytes
    offsets: bytes | None
    wear: WearOffset
    changes: list[ChangedWord]
    notes: list[str]


def write_programs(inputs: Inputs, writing: Writing, decision: Decision, paths: Paths) -> Programs:
    """Writes them and reads them back. Raises NC and CMP errors that name the program; CMP-SIZE for a large offset."""
    change_mm = inputs.in_force.cut_with.still_to_do(decision.whole_offset_mm)
    wear, notes = _wear(writing, decision, change_mm, inputs.options, inputs.held)
    if inputs.machine is not None:
        offsets, more = None, _of_machine(inputs.machine, inputs.touches, compensated=inputs.in_force.composed)
    elif inputs.no_offset and writing.program.dialect.contour_shift == "UPD":
        offsets, more = None, []
    else:
        offsets, more = _offset_variant(writing, decision, change_mm, inputs.options, wear)
    notes += more
    if decision.by_offset:
        source, changed = offsets or (inputs.program.source, [])
    else:
        with in_file(inputs.program.file):
            source, changed, more = write_contour(writing, inputs.profile, inputs.touches, paths)
        notes += more
    return Programs(source, offsets[0] if offsets else None, wear, changed, notes)


def _of_machine(cut: PartOnMachine, measured: ErrorVectors, *, compensated: bool) -> list[str]:
    """Returns notes on a composed correction. `compensated`: the program that cut the part carried COMP_MTG."""
    probed = cut.touched_on == "machine"
    where = wording("corrected by COMP_MTG(T_probing)") if probed else wording("taken as they are: by a CMM")
    carried = cut.semifinish_cut == "uncompensated" and not compensated
    how = wording("uncompensated") if carried else wording("compensated")
    touches = [wording("The touches were {where}.", where=where)] if measured.by_probe.any() else []
    readings = [wording("Readings and points of inspection files are taken as they are: measured off the machine.")]
    return [
        wording(
            "The contour carries COMP_MTG of {machine!r} at the finish cut's temperatures and COMP_PROC; the measured "
            "surface was cut {how}.",
            machine=cut.model.machine.name,
            how=how,
        ),
        *touches,
        *(readings if measured.seen or measured.by_cmm else []),
        wording("There is no variant with tool offsets alone: it would leave the machine's error."),
    ]


def _wear(
    writing: Writing, decision: Decision, change_mm: tuple[float, float], options: Options, held: HeldTool
) -> tuple[WearOffset, list[str]]:
    """Returns the change of the offset as numbers to enter, of the tool that the job names, else that of the program's
    T word.

    Raises OFS-TOOL where the job names the tool's row of a table and the program runs with another row, or with another
    edge than is stated, and where the offset makes the correction and neither job nor program gives the tool a number.
    """
    program, path, cut = writing.program, writing.matched.path, writing.matched.cuts[0].move
    own = called(program.dialect, path, cut)
    tool = options.tool or (0 if own is None else own.number)
    left_out = not_in_force(program, path, cut)
    tool = 0 if left_out else tool
    if not tool and decision.by_offset and not left_out:
        raise no_number(program, int(path.line[cut]))
    notes = [] if options.by == "auto" else [_asked_for(options.by)]
    notes += [left_out] if left_out and decision.by_offset else []
    if tool and own is not None and own.number != tool:
        if held.row is not None or decision.by_offset:
            raise _other_row(program, tool, own.number, int(path.line[cut]))
        notes.append(
            wording(
                "The job says tool {tool}; the finish pass in line {line} runs with offset {own}: a number entered for "
                "tool {tool} would move another tool.",
                tool=tool,
                line=int(path.line[cut]),
                own=own.number,
            )
        )
        tool = 0
    edge = edge_of_pass(program, path, cut, held.edge)
    with in_file(program.file):
        wear = wear_offset(
            *(program, path, cut, change_mm, tool, options.offset_is_diameter, edge),
            expanded_u_mm=decision.expanded_u_mm,
        )
    return wear, notes


def edge_of_pass(program: Program, path: ToolPath, cut: int, stated: int) -> int:
    """Returns the edge of a move of the finish pass, 1 where none is stated (0). Raises OFS-TOOL: they differ."""
    edge, line = edge_called(program.dialect, path, cut), int(path.line[cut])
    if edge is None or not stated or edge == stated:
        return edge or stated or 1
    raise Code.OFS_TOOL.refusal(
        f"the job names edge {stated} of the tool (`tool.table_edge`; 1 where a table is named without it); the finish "
        f"pass in line {line} runs with edge {edge}",
        hint=f"tool.table_edge = {edge}, the edge of the finish pass",
        place=Place(program.file, line),
        values={"tool": float(path.tool[cut])},
    )


def no_number(program: Program, line: int) -> TrueloopError:
    """Returns OFS-TOOL for a finish pass whose tool has a name or no T word, where its offset is to be changed."""
    return Code.OFS_TOOL.refusal(
        f"the finish pass in line {line} is cut by a tool without a number (called by a name, or no T word before it): "
        "which offset to change is not known",
        hint="put the number of the finishing tool's offset into `tool.number`",
        place=Place(program.file, line),
        values={"tool": 0.0},
    )


def not_in_force(program: Program, path: ToolPath, cut: int) -> str:
    """Returns why a number entered into the tool's offset would not move its finish pass; "": it would."""
    if not runs_without_offset(program.dialect, path, cut):
        return ""
    return wording(
        "The finish pass in line {line} runs without the tool's offset of the control's table ({how}): a number "
        "entered there would move nothing.",
        line=int(path.line[cut]),
        how=_left_out(program, path, cut),
    )


def _left_out(program: Program, path: ToolPath, cut: int) -> str:
    if program.dialect.wear_words == "linuxcnc":
        return wording("no G43 with the tool's number before it")
    return "D0 / OG=0" if program.dialect.edge_by_d and int(path.tool[cut]) < 100 else f"T{int(path.tool[cut]):04d}"


def require_in_force(program: Program, path: ToolPath, cut: int) -> None:
    """Raises OFS-TOOL where no offset of the tool is in force in its finish pass."""
    if why := not_in_force(program, path, cut):
        raise Code.OFS_TOOL.refusal(
            why.removesuffix("."),
            hint="call the tool with its offset in the program (T0303, D1, G43) before its finish pass, or correct the "
            "contour",
            place=Place(program.file, int(path.line[cut])),
            values={"tool": float(path.tool[cut])},
        )


def _asked_for(by: str) -> str:
    how = wording("offset") if by == "offset" else wording("contour")
    return wording("The job wants the correction by {how}, whatever the test says.", how=how)


def _other_row(program: Program, tool: int, own: int, line: int) -> TrueloopError:
    return Code.OFS_TOOL.refusal(
        f"the job names tool {tool}; the finish pass in line {line} runs with offset {own}",
        hint="put the number of the finish pass' offset into `tool.number`",
        place=Place(program.file, line),
        values={"tool": float(tool)},
    )


def _offset_variant(
    writing: Writing, decision: Decision, change_mm: tuple[float, float], options: Options, wear: WearOffset
) -> tuple[tuple[bytes, list[ChangedWord]] | None, list[str]]:
    """Returns the program with offsets alone, or a note that it is left out: the offset can be entered by hand."""
    try:
        check_offset(decision.whole_offset_mm, options.limits)
        with in_file(writing.program.file):
            variant = write_offsets(writing, change_mm, wear.tool, options.offset_is_diameter)
    except TrueloopError as refused:
        if refused.code is not Code.NC_OFFSET and (decision.by_offset or refused.code is not Code.CMP_SIZE):
            raise
        notes: list[str] = [wording("There is no variant with tool offsets alone: {why}.", why=refused.message)]
        if decision.by_offset:
            notes.append(
                wording("Enter the offset at the control ({wear}) and run the program as it is, once.", wear=wear.words)
            )
        return None, notes
    return variant, []


def write_offsets(
    writing: Writing, offset_mm: tuple[float, float], tool: int, is_diameter: bool | None
) -> tuple[bytes, list[ChangedWord]]:
    """Returns the program with the tool's offset changed by (x as a radius, z), and the changes.

    Raises NC-OFFSET where none can be written around the contour, CMP-READ-BACK if reading it back says so.
    """
    if has_local_shift(writing.program):
        program, path, cuts = writing.program, writing.matched.path, _cuts(writing.matched)
        shifted = shifted_moves(program, path, cuts)
        edits = shift_edits(program, path, shifted, offset_mm)
        after = writing.run.of(writing.reread(writing.with_edits(edits)))
        step_mm = program.dialect.step_mm(bool(path.inch[shifted.first]))
        require_shift(program, path, after, shifted, cuts, offset_mm, step_mm / 2 + SAME_MM)
    else:
        edits = _updated(writing, offset_mm, tool, is_diameter)
    return writing.with_edits(edits), changes(writing.program, edits)


def _updated(writing: Writing, offset_mm: tuple[float, float], tool: int, is_diameter: bool | None) -> list[Edit]:
    program, path, lead = writing.program, writing.matched.path, max(_cuts(writing.matched)[0] - 1, 0)
    state = offset_state(path.coordinate_state(lead), is_diameter)
    values_mm = tool_offset_updates(program, state, offset_mm, tool)
    edits = update_edits(program, path, lead, values_mm, tool, is_diameter)
    after = writing.reread(writing.with_edits(edits))
    require_same_path(path, writing.run.of(after))
    require_updates(after, state, values_mm, tool)
    return edits


def _cuts(matched: Commanded) -> tuple[int, int]:
    """Returns the first and last move of the contour, those that only lengthen it included."""
    moves = [*(cut.move for cut in matched.cuts), *(move.index for move in matched.match.run_out)]
    return min(moves), max(moves)
