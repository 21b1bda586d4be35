"""The programs of a correction: the contour's, the variant with tool offsets alone, and the offset as numbers."""

from dataclasses import dataclass

from trueloop.domain.record import ChangedWord
from trueloop.domain.tool_offset import HeldTool
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.part_on_machine import PartOnMachine
from trueloop.loops.turned.paths import Paths
from trueloop.loops.turned.written import Writing, write_contour
from trueloop.loops.turned.written_offsets import write_offsets
from trueloop.nc.program.called import called
from trueloop.nc.program.program import Program
from trueloop.turned.compensation.decide import Decision
from trueloop.turned.compensation.limits import check_offset
from trueloop.turned.options import Options
from trueloop.turned.program.wear import wear_offset
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.wording import wording


@dataclass(frozen=True)
class Programs:
    """The corrected program as the decision wants it, and its variant with `wear` written into it, if there is one.

    `changes` are those of the one to run, `notes` what to know before running it.
    """

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
        offsets, more = None, _of_machine(inputs.machine)
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


def _of_machine(cut: PartOnMachine) -> list[str]:
    """What to know of a composed correction."""
    where = (
        wording("corrected by COMP_MTG(T_probing)")
        if cut.touched_on == "machine"
        else wording("taken as they are: by a CMM")
    )
    how = wording("uncompensated") if cut.semifinish_cut == "uncompensated" else wording("compensated")
    return [
        wording(
            "The contour carries COMP_MTG of {machine!r} at the finish cut's temperatures and COMP_PROC; the touches "
            "were {where}; the touched surface was cut {how}.",
            machine=cut.model.machine.name,
            where=where,
            how=how,
        ),
        wording("There is no variant with tool offsets alone: it would leave the machine's error."),
    ]


def _wear(
    writing: Writing, decision: Decision, change_mm: tuple[float, float], options: Options, held: HeldTool
) -> tuple[WearOffset, list[str]]:
    """The change of the offset as numbers to enter, of the tool that the job names, else that of the program's T word.

    Raises OFS-TOOL where the job names the tool's row of a table and the program runs with another row, and where the
    offset makes the correction and neither job nor program gives the tool a number.
    """
    program, path, cut = writing.program, writing.matched.path, writing.matched.cuts[0].move
    own = called(program.dialect, path, cut)
    tool = options.tool or (0 if own is None else own.number)
    if not tool and decision.by_offset:
        raise no_number(program, int(path.line[cut]))
    if held.row is not None and own is not None and own.number != tool:
        raise _other_row(program, tool, own.number, int(path.line[cut]))
    notes = [] if options.by == "auto" else [_asked_for(options.by)]
    if own is not None and own.number != tool:
        notes.append(
            wording(
                "The job says tool {tool}; the finish pass in line {line} runs with offset {own}.",
                tool=tool,
                line=int(path.line[cut]),
                own=own.number,
            )
        )
    edge = own.edge if own is not None and own.number == tool and held.row is None else held.edge
    with in_file(program.file):
        wear = wear_offset(
            *(program, path, cut, change_mm, tool, options.offset_is_diameter, edge),
            expanded_u_mm=decision.expanded_u_mm,
        )
    return wear, notes


def no_number(program: Program, line: int) -> TrueloopError:
    """OFS-TOOL: a finish pass whose tool has a name or no T word, where its offset is to be changed."""
    return TrueloopError(
        Code.OFS_TOOL,
        f"the finish pass in line {line} is cut by a tool without a number (called by a name, or no T word before it): "
        "which offset to change is not known",
        hint="put the number of the finishing tool's offset into `tool.number`",
        place=Place(program.file, line),
        values={"tool": 0.0},
    )


def _asked_for(by: str) -> str:
    how = wording("offset") if by == "offset" else wording("contour")
    return wording("The job wants the correction by {how}, whatever the test says.", how=how)


def _other_row(program: Program, tool: int, own: int, line: int) -> TrueloopError:
    return TrueloopError(
        Code.OFS_TOOL,
        f"the job names row {tool} of its tool table; the finish pass in line {line} runs with offset {own}",
        hint="put the number of the finish pass' offset into `tool.number`",
        place=Place(program.file, line),
        values={"tool": float(tool)},
    )


def _offset_variant(
    writing: Writing, decision: Decision, change_mm: tuple[float, float], options: Options, wear: WearOffset
) -> tuple[tuple[bytes, list[ChangedWord]] | None, list[str]]:
    """The program with offsets alone. It may be left out, which a note says: the offset can be entered by hand."""
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
