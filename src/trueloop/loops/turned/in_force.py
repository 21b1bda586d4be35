"""The correction in force when a measured part was cut, as the loop takes it: the program that ran, and the tool's
offset.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from trueloop.domain.life import Ran
from trueloop.domain.proposal import HeldTool, TableRow, ToolOffset
from trueloop.domain.record import GIVEN, ChangedWord, CutWith, Product, Record, sha256_of
from trueloop.errors import Code
from trueloop.nc.edit.edit import Edit, apply_edits
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.program import Program
from trueloop.units import MM_PER_INCH
from trueloop.wording import first_of, wording

HINT: Final = 'state `programs.cut_with = "given"`, or the record of the correction in force'


@dataclass(frozen=True)
class InForce:
    """The correction with which the measured part was cut. `program` is the corrected one, where one ran, and `lines`
    its finish pass, `composed` that it carries COMP_MTG of a machine model; None: the given program ran. `stated`: by
    the job or the store. Else `stored` is the id of a correction that the store is to know and `by` how it was carried
    out, or `possible` are, in words, corrections that may have been in force. `record` is that of the one in force.
    """

    cut_with: CutWith = GIVEN
    program: Program | None = None
    lines: tuple[int, int] | None = None
    composed: bool = False
    stated: bool = False
    stored: str = ""
    by: Ran | None = None
    possible: tuple[str, ...] = ()
    record: Record | None = None

    def require_stated(self) -> None:
        """Raises CMP-CUT-WITH where several corrections may have cut the part and none that is known is stated."""
        if self.stored and not self.stated:
            raise Code.CMP_CUT_WITH.refusal(
                f"programs.cut_with names correction {self.stored!r}, and the job has no store that holds it",
                hint='name the path to its record: cut_with = "o1/record.json"',
                values={"corrections": [self.stored]},
            )
        if self.stated or not self.possible:
            return
        raise Code.CMP_CUT_WITH.refusal(
            wording(
                "what cut the measured part is not stated: the given program, or a correction of it: {shown}",
                shown=first_of(self.possible, 4),
            ),
            hint=f"{HINT} by its path or, with a store, its id, in the table of the job that names the program; of "
            "several tools or set-ups the path to their `part.json`",
            values={"corrections": list(self.possible)},
        )

    def require_held(self, held: HeldTool) -> None:
        """Raises OFS-CHANGED where a given table stands as before the wear entered, or holds a program's offset."""
        offset = None if self.record is None else self.record.tool_offset
        if offset is None or offset.held.row is None or held.row is None or not (offset.x_radius_mm or offset.z_mm):
            return
        before, now = offset.held.row, held.row
        by_wear, of = self.cut_with.ran is Ran.WEAR, f"correction {self.cut_with.correction}"
        if by_wear and (before.x, before.z, before.unit, before.kind) == (now.x, now.z, now.unit, now.kind):
            why = f"stands as before {of}, which is stated as entered at the control"
        elif not by_wear and _is_entered(offset, before, now):
            why = f"holds {of}, which is stated as run in a program: {self.cut_with.ran.value!r}"
        else:
            return
        raise Code.OFS_CHANGED.refusal(
            f"the row of tool {offset.tool} in {now.file!r} {why}: X {now.x}, Z {now.z}",
            hint="name the table that is in force with the next cut, `tool.table`, and state what cut the part in "
            "`programs.cut_with` and `programs.cut_by`",
            values={"tool": float(offset.tool)},
        )


def _is_entered(offset: ToolOffset, before: TableRow, now: TableRow) -> bool:
    """Returns whether a row is what an offset makes of it, to half a step; X counts as a radius or as a diameter."""
    if (before.unit, before.kind) != (now.unit, now.kind):
        return False
    unit_mm = 1.0 if now.unit == "mm" else MM_PER_INCH
    x, z = (unit_mm * (float(b or 0.0) - float(a or 0.0)) for a, b in ((before.x, now.x), (before.z, now.z)))
    step_mm = unit_mm * 10.0**-offset.decimals
    off_mm = min(abs(x - counts * offset.x_radius_mm) for counts in (1.0, 2.0))
    return max(off_mm, abs(z - offset.z_mm)) <= 0.5 * step_mm


NOTHING: Final = InForce()
"""The given program ran, and nothing was in force."""


def in_force(
    record: Record, by: Ran | None, program: Program, lines: tuple[int, int] | None, sha256: str = ""
) -> InForce:
    """Returns a correction of `program` as it was in force, carried out `by` one of its ways; None: by its only one.

    `lines` of the given program's finish pass; `sha256` of the text that ran, "" where it is not known. Raises
    CMP-CUT-WITH where the record has several ways and none is stated, or cannot be carried out so, CMP-OTHER-PROGRAM
    where it is of another program.
    """
    if record.product is not Product.TURNED or record.program is None:
        raise Code.CMP_CUT_WITH.refusal(
            f"record {record.id} is no correction of a turned part's program",
            hint=HINT,
            values={"corrections": [record.id]},
        )
    given = sha256_of(program.source)
    if record.program.sha256 != given:
        raise Code.CMP_OTHER_PROGRAM.refusal(
            f"correction {record.id} is of the program with sha256 {record.program.sha256[:16]}…, this one has "
            f"{given[:16]}…",
            hint="name in `programs.finish` the program that the correction was made from",
            values={"expected_sha256": record.program.sha256, "found_sha256": given},
        )
    ran = _way(record, by)
    if ran is not Ran.CORRECTED:
        return InForce(cut_with(record, ran, sha256 or (given if ran is Ran.WEAR else "")), record=record)
    edits = edits_of(program, record.changes)
    return InForce(
        cut_with(record, ran, sha256),
        program.rewritten(apply_edits(program, edits)),
        None if lines is None else lines_after(record.changes, lines),
        composed=bool(record.components),
        record=record,
    )


def _way(record: Record, by: Ran | None) -> Ran:
    ways = ways_of(record)
    if by is None and len(ways) == 1:
        return ways[0]
    if by is not None and by in (*ways, *_ways_beside(record)):
        return by
    if by is Ran.CORRECTED and Ran.OFFSETS in ways:  # one text under both names
        return Ran.OFFSETS
    said = " or ".join(f'"{way}"' for way in ways)
    what = (
        f"is carried out by {said}, not by {by.value!r}, as is stated"
        if by is not None
        else (f"can be carried out in several ways, and the job does not state which was in force: {said}")
    )
    hint = f"cut_by = {said} (the program of that name, or the offset entered at the control)"
    if "edge" in record.options:
        hint = "without `cut_by` each tool counts as its own correction was decided"
    raise Code.CMP_CUT_WITH.refusal(
        f"correction {record.id} {what}",
        hint=f"state it in the job's table [programs]: {hint}",
        values={"corrections": [record.id]},
    )


def _ways_beside(record: Record) -> tuple[Ran, ...]:
    """Returns the further ways: a contour's offset in its place. Of several tools none with offsets is written."""
    offset = record.tool_offset
    if offset is None:
        return ()
    program = () if offset.makes_the_correction or "edge" in record.options else (Ran.OFFSETS,)
    return (*program, *((Ran.WEAR,) if keeps_wear(record) else ()))


def keeps_wear(record: Record) -> bool:
    """Returns whether wear that is entered at the control moves the cut and stays: not where programs set the offset
    themselves (UPD), nor where the finish pass runs without the tool's offset (T0300, D0), and its program is shifted.
    """
    offset = record.tool_offset
    if offset is not None and offset.makes_the_correction and not offset.tool:
        return False
    return record.program is None or dialect_named(record.program.dialect).contour_shift != "UPD"


def ways_of(record: Record) -> tuple[Ran, ...]:
    """Returns the ways to carry a correction out: a contour, an offset's program if written, or the wear table."""
    offset = record.tool_offset
    if offset is None or not offset.makes_the_correction:
        return (Ran.CORRECTED,)
    if record.changes and "edge" not in record.options:
        return (Ran.OFFSETS, Ran.WEAR) if keeps_wear(record) else (Ran.OFFSETS,)
    return (Ran.WEAR,)


def cut_with(record: Record, ran: Ran, program_sha256: str = "") -> CutWith:
    """Returns what is in force when a correction is carried out in one of its ways, on top of what stays in force."""
    stays = GIVEN.wear_mm if record.cut_with is None else record.cut_with.wear_mm
    offset = record.tool_offset
    change = (0.0, 0.0) if offset is None else (offset.x_radius_mm, offset.z_mm)
    moved = (0.0, 0.0) if ran is Ran.CORRECTED else change
    whole = (stays[0] + moved[0], stays[1] + moved[1])
    return CutWith(ran, record.id, program_sha256, whole, whole if ran is Ran.WEAR else stays)


def edits_of(program: Program, changed: Sequence[ChangedWord]) -> list[Edit]:
    """Returns the edits that a record lists. Raises REC-KEY where the program does not read as it says."""
    found = []
    for word in changed:
        start = program.block(word.line - 1).start + word.column - 1
        before = word.before.encode("latin-1")
        if program.source[start : start + len(before)] != before:
            raise Code.REC_KEY.refusal(
                f"'changes': {word.before!r} does not stand in line {word.line}, column {word.column}, of the program "
                "that the record names",
                hint="restore the record as trueloop wrote it",
            )
        found.append(Edit(start, start + len(before), word.after))
    return found


def lines_after(changed: Sequence[ChangedWord], lines: tuple[int, int]) -> tuple[int, int]:
    """Returns the place of lines (from, to) of a program after changes were written into it, without its heading."""

    def more(before: int) -> int:
        return sum(word.after.count("\n") - word.before.count("\n") for word in changed if word.line < before)

    first, last = lines
    return first + more(first), last + more(last + 1)
