"""One program that carries the corrections of several edges: each made and read back by itself, then all in one.

The joint program is not trusted to be the sum of its parts: it is read again and run, and every move has to be that of
the correction that moved it, or, outside of all of them, that of the source.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from typing import Final, TypeAlias

import numpy as np

from trueloop.domain.judged import Judged
from trueloop.domain.record import marks_of_record, record_id
from trueloop.errors import in_file
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.in_force import edits_of
from trueloop.loops.turned.own_inputs import own_inputs, shared_words
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.loops.turned.shared_sizes import Share, shared_sizes
from trueloop.nc.edit.changes import not_as_intended
from trueloop.nc.edit.edit import Edit, apply_edits
from trueloop.nc.edit.heading import insert_heading
from trueloop.nc.match.own_contour import OwnContour
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath

DECIMALS: Final = 6
"""Two moves that agree to so many decimals of a millimetre are the same: controls resolve a tenth of a micrometre."""

_Row: TypeAlias = tuple[float, ...]


@dataclass(frozen=True)
class OfEdge:
    """One edge of a program: what it cuts, its correction, and what that was made from; None: nothing was measured of
    what it cuts.
    """

    contour: OwnContour
    correction: Correction | None
    inputs: Inputs | None

    @property
    def tool(self) -> str:
        """As the program calls it, and which corner it is."""
        return self.contour.edge.words


@dataclass(frozen=True)
class Joint:
    """The corrections of all edges of one program, and the program that carries them.

    `program` is None where every correction is an offset, or nothing was measured: the given one is run. `record_id`
    stands in it, and is of the corrections' own ids. `characteristics` are those between features of two edges.
    """

    part: str
    source_name: str
    source: bytes
    edges: tuple[OfEdge, ...]
    program: bytes | None
    record_id: str
    notes: tuple[str, ...]
    characteristics: tuple[Judged, ...] = ()

    @property
    def corrections(self) -> tuple[Correction, ...]:
        """Those that there are."""
        return tuple(one.correction for one in self.edges if one.correction is not None)


def correct_edges(
    cuts: Sequence[tuple[OwnContour, Inputs]], name: str, known: Callable[[Inputs, OwnContour], Inputs] | None = None
) -> Joint:
    """The corrections of a program's edges, each with inputs of the whole part and its own tool; `name` is that of the
    file that carries them. `known` adds to the inputs of one edge what is known of it. Raises what correcting one
    raises, and CMP-READ-BACK where the whole is not their sum.
    """
    owns = [own_inputs(inputs, own) for own, inputs in cuts]
    if known is not None:
        owns = [None if one is None else known(one, own) for one, (own, _) in zip(owns, cuts, strict=True)]
    made = [None if own is None else compensate(own) for own in owns]
    whole = cuts[0][1]
    joint_id = record_id(dict(whole.inputs_sha256), {"corrections": [one.record.id for one in made if one is not None]})
    with in_file(whole.program.file):
        program = _written(whole, [one for one in made if one is not None and not one.decision.by_offset], joint_id)
    edges = tuple(
        OfEdge(own, None if one is None else _as_joint(one, program, name), inputs)
        for (own, _), one, inputs in zip(cuts, made, owns, strict=True)
    )
    shares = [Share(one.contour, one.correction) for one in edges if one.correction is not None]
    touched = np.bincount(whole.touches.feature_index, minlength=len(whole.profile.features)).astype(np.intp)
    sizes = shared_sizes(whole.profile, whole.characteristics, touched, shares)
    return Joint(
        part=whole.part.name,
        source_name=whole.program.file_name,
        source=whole.program.source,
        edges=edges,
        program=program,
        record_id=joint_id,
        notes=shared_words(whole, tuple(own for own, _ in cuts), [one.characteristic.name for one in sizes]),
        characteristics=sizes,
    )


def _as_joint(correction: Correction, program: bytes | None, name: str) -> Correction:
    """The correction with the program that carries all in the place of its own; offsets alone are entered by hand."""
    source = correction.source_program if program is None else program
    run = correction.source_name if program is None else name
    return replace(correction, corrected_program=source, offsets_program=None, joint_name=run)


def _written(inputs: Inputs, corrections: Sequence[Correction], joint_id: str) -> bytes | None:
    if not corrections:
        return None
    program, run = inputs.program, Run(inputs.parameters, inputs.execute_deleted_blocks)
    edits = [edit for one in corrections for edit in edits_of(program, one.record.changes)]
    source = apply_edits(program, [_mark(program, corrections, joint_id), *edits])
    paths = [run.of(program.rewritten(one.corrected_program)) for one in corrections]
    require_sum(run.of(program), paths, run.of(program.rewritten(source)))
    return source


def _mark(program: Program, corrections: Sequence[Correction], joint_id: str) -> Edit:
    of_edges = [f"{one.record.options['edge']}: record {one.record.id}" for one in corrections]
    lines = [*marks_of_record(joint_id, program.source), *of_edges]
    return insert_heading(program, [program.dialect.comment(line) for line in lines])


def require_sum(before: ToolPath, singles: Sequence[ToolPath], joint: ToolPath) -> None:
    """Refuses a joint path that is not the source's with what each single path changes of it in its place."""
    source = _rows(before)
    wanted, done = list[_Row](), 0
    for first, last, rows in sorted(
        (one for path in singles for one in _changed(source, _rows(path))), key=lambda c: c[:2]
    ):
        if first < done:
            raise not_as_intended(f"two edges' corrections both move the cut of line {before.line[first]}")
        wanted += [*source[done:first], *rows]
        done = last
    wanted += source[done:]
    found = _rows(joint)
    if len(found) != len(wanted):
        raise not_as_intended(f"the joint program makes {len(found)} moves; its corrections make {len(wanted)}")
    for k, (is_now, shall_be) in enumerate(zip(found, wanted, strict=True)):
        if is_now != shall_be:
            raise not_as_intended(f"the move of line {joint.line[k]} of the joint program is not its correction's")


def _changed(source: Sequence[_Row], single: Sequence[_Row]) -> Iterator[tuple[int, int, Sequence[_Row]]]:
    """Stretches of the source that a single path has otherwise: first move, one after the last, and its own moves."""
    matcher = SequenceMatcher(None, source, single, autojunk=False)
    for kind, first, last, begin, end in matcher.get_opcodes():
        if kind != "equal":
            yield first, last, single[begin:end]


def _rows(path: ToolPath) -> list[_Row]:
    """What each move is and where it goes, to a nanometre: nothing of lines or of what is called."""
    values = np.column_stack([path.motion, path.end_mm, np.nan_to_num(path.centre_mm), path.sweep_rad])
    return [tuple(row) for row in np.round(values.astype(np.float64), DECIMALS).tolist()]
