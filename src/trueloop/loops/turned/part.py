"""The corrections of a part: set-up by set-up, edge by edge, and the programs that carry them.

Every edge is corrected and read back by itself. What it changes is a list of edits of its program; those of all edges
of a program are composed before anything is written. The whole is not trusted to be the sum of its parts: it is read
again and run, and every move has to be that of the correction that moved it, or, outside of all of them, that of the
source. A part that one tool cuts in one set-up goes the same way.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from typing import Final, TypeAlias

import numpy as np

from trueloop.domain.characteristic import Characteristic, Judged
from trueloop.domain.record import Record, marks_of_record, record_id
from trueloop.domain.tool import Machine
from trueloop.errors import Code, in_file
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import PART, SetupFrame
from trueloop.loops.turned.characteristics import Share, lengths
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.in_force import InForce, edits_of
from trueloop.loops.turned.process_intermittent import compensate, zero_in_machine
from trueloop.loops.turned.share import inputs_of_edge, judged_on_part, own_inputs, shared_words
from trueloop.nc.edit.changes import insert_heading, not_as_intended, verify_written
from trueloop.nc.edit.edit import Edit, apply_edits
from trueloop.nc.match.cutters import CuttingEdge
from trueloop.nc.match.own_contour import OwnContour
from trueloop.nc.program.called import CalledOffset
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.turned.readings.vectors import z_zero
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import all_of, wording

DECIMALS: Final = 6
"""Two moves that agree to so many decimals of a millimetre are the same: controls resolve a tenth of a micrometre."""

Cut: TypeAlias = tuple[OwnContour | None, Inputs]
"""The features that an edge cuts (None: the whole profile, whichever tool the program calls), and inputs of the whole
set-up with that edge's tool."""
Known: TypeAlias = Callable[[Inputs, OwnContour | None], Inputs]
"""Adds to the inputs of one edge what is known of it."""


@dataclass(frozen=True)
class SetupCuts:
    """One set-up's cuts: `features` in the part's order, edges, its program's offsets; `frame`: its own, if any."""

    cuts: tuple[Cut, ...]
    frame: SetupFrame = PART
    features: tuple[str, ...] = ()
    calls: frozenset[CalledOffset] = frozenset()

    @property
    def program(self) -> Program:
        """Returns the finish program of its edges."""
        return self.cuts[0][1].program

    @property
    def name(self) -> str:
        """Returns the file name of the program that carries the corrections of all edges."""
        named = f"-{self.frame.name}" if self.frame.name else ""
        _, dot, ending = self.program.file_name.rpartition(".")
        return f"corrected{named}{dot}{ending if dot else ''}"


@dataclass(frozen=True)
class EdgeCorrection:
    """One edge of a program: what it cuts, its correction, and what that was made from; None: nothing was measured of
    what it cuts, and the correction `kept` stays in force. `contour` None: the job's one tool, which cuts the whole
    profile.
    """

    contour: OwnContour | None
    correction: Correction | None
    inputs: Inputs | None
    kept: Record | None = None

    @property
    def tool(self) -> str:
        """Describes the tool as the program calls it, and which corner it is."""
        if self.contour is not None:
            return self.contour.edge.words
        return "" if self.correction is None else self.correction.wear.called

    @property
    def features(self) -> tuple[str, ...]:
        """Names of the features that it cuts."""
        if self.contour is not None:
            return self.contour.profile.names
        return () if self.correction is None else self.correction.profile.names


@dataclass(frozen=True)
class SetupCorrection:
    """The corrections of all edges of one program, and the program that carries them.

    `program` is None where every correction is an offset, or nothing was measured: the given one is run. `record_id`
    stands in it, and is of the corrections' own ids. `name` is that of its file. `characteristics` are those between
    features of two edges.
    """

    part: str
    frame: SetupFrame
    features: tuple[str, ...]
    source_name: str
    source: bytes
    edges: tuple[EdgeCorrection, ...]
    program: bytes | None
    record_id: str
    name: str
    notes: tuple[str, ...]
    characteristics: tuple[Judged, ...] = ()

    @property
    def corrections(self) -> tuple[Correction, ...]:
        """Returns the existing corrections of its edges."""
        return tuple(edge.correction for edge in self.edges if edge.correction is not None)


@dataclass(frozen=True)
class PartCorrection:
    """The corrections of all set-ups of a part; `profile` is the part's. `record_id` is of the set-ups' own ids.

    `characteristics` are those between faces of two set-ups, `uncut` the features that none cuts.
    """

    part: str
    profile: Profile
    setups: tuple[SetupCorrection, ...]
    uncut: tuple[str, ...]
    record_id: str
    notes: tuple[str, ...]
    characteristics: tuple[Judged, ...] = ()

    @property
    def alone(self) -> Correction | None:
        """Returns the correction of a part whose job has one tool; None: it lists its edges."""
        edge = self.setups[0].edges[0]
        return edge.correction if edge.contour is None else None

    @property
    def in_setups(self) -> bool:
        """Returns whether the job lists set-ups."""
        return bool(self.setups[0].frame.name)

    @property
    def edges(self) -> tuple[EdgeCorrection, ...]:
        """Returns the edges of all set-ups."""
        return tuple(edge for setup in self.setups for edge in setup.edges)


def correct_part(
    profile: Profile,
    cuts: Sequence[SetupCuts],
    asked: Sequence[Characteristic],
    vectors: ErrorVectors,
    uncut: Sequence[str] = (),
    notes: Sequence[str] = (),
    edge_state: Known | None = None,
) -> PartCorrection:
    """Corrects every program: all of them, or none. `asked` are the part's characteristics, `vectors` the measured
    errors in its frame.

    Raises what correcting one edge raises, CMP-READ-BACK where a program is not the sum of its corrections, and
    SET-OFFSET where the job wants an offset that cannot be entered.
    """
    done = tuple(correct_setup(_by_what_may_be(cut, cuts), asked, edge_state) for cut in cuts)
    whole = cuts[0].cuts[0][1]
    if not cuts[0].frame.name:
        return PartCorrection(
            part=whole.part.name, profile=profile, setups=done, uncut=(), record_id=done[0].record_id, notes=()
        )
    finished = all(of.measured_finished for cut in cuts for _, of in cut.cuts)
    allowed = any(of.allowance_mm or of.measured_allowance_mm for cut in cuts for _, of in cut.cuts)
    sizes = (
        ()
        if allowed
        else lengths(profile, asked, vectors, [_shares(correction) for correction in done], finished=finished)
    )
    return PartCorrection(
        part=whole.part.name,
        profile=profile,
        setups=done,
        uncut=tuple(uncut),
        record_id=record_id(dict(whole.inputs_sha256), {"setups": [correction.record_id for correction in done]}),
        notes=(*_left(uncut), *notes, *_unjudged(done, asked, sizes, bool(len(z_zero(vectors))))),
        characteristics=sizes,
    )


def with_zero(cuts: Sequence[SetupCuts]) -> tuple[SetupCuts, ...]:
    """Returns the cuts with what the machine errs by at the place from which z counts, which one edge cuts, for the
    other edges of its set-up. In the other set-ups the part stands on that face as it was cut: no error of the machine
    of the set-up that cut it is in their z. Raises NC, GEO and MCH errors.
    """
    if sum(len(cut.cuts) for cut in cuts) == 1 or cuts[0].cuts[0][1].machine is None:
        return tuple(cuts)
    return tuple(_from_zero(cut) for cut in cuts)


def _from_zero(of: SetupCuts) -> SetupCuts:
    for own, whole in of.cuts:
        mine = own_inputs(whole, own)
        zero = None if mine is None else zero_in_machine(mine)
        if zero is not None:
            return replace(of, cuts=tuple((own, replace(inputs, zero=zero)) for own, inputs in of.cuts))
    return of


def correct_setup(
    of: SetupCuts, asked: Sequence[Characteristic] | None = None, edge_state: Known | None = None
) -> SetupCorrection:
    """Returns the corrections of a program's edges, and the program that carries all. `asked` as in `correct_part`."""
    owns = [own_inputs(inputs, own) for own, inputs in of.cuts]
    if edge_state is not None:
        owns = [None if one is None else edge_state(one, own) for one, (own, _) in zip(owns, of.cuts, strict=True)]
    made = [None if own is None else compensate(own) for own in owns]
    pairs = zip(made, of.cuts, strict=True)
    kept = [_kept(inputs, own, edge_state) if correction is None else None for correction, (own, inputs) in pairs]
    contours, whole = tuple(own for own, _ in of.cuts if own is not None), of.cuts[0][1]
    if not contours:
        (alone,) = made
        assert alone is not None
        edges: tuple[EdgeCorrection, ...] = (EdgeCorrection(None, alone, owns[0]),)
        program = None if alone.runs_as_given else alone.corrected_program
        return _setup(of, edges, program, alone.record.id, alone.name_to_run)
    records = [one.record for one in (*made, *kept) if one is not None]
    joint_id = record_id(
        dict(whole.inputs_sha256), {"corrections": [record.id for record in records if record is not None]}
    )
    with in_file(whole.program.file):
        changed = [
            (correction.record, correction.corrected_program)
            for correction in made
            if correction is not None and not correction.decision.by_offset
        ]
        stays = {
            in_force.record.id: (in_force.record, in_force.program.source)
            for in_force in kept
            if in_force and in_force.record and in_force.program
        }
        program = _composed(whole, [*changed, *stays.values()], joint_id)
    drawn = whole.characteristics if asked is None else asked
    edges = tuple(
        EdgeCorrection(
            own,
            None if correction is None else _as_joint(_with_between(correction, own, whole, drawn), program, of, asked),
            inputs,
            force.record if force else None,
        )
        for (own, _), correction, inputs, force in zip(of.cuts, made, owns, kept, strict=True)
    )
    done = _setup(of, edges, program, joint_id, of.name)
    shares = [_shares(replace(done, frame=PART))]
    sizes = lengths(whole.profile, whole.characteristics, whole.touches, shares, finished=whole.measured_finished)
    words = shared_words(whole, contours, [size.characteristic.name for size in sizes])
    return replace(done, notes=words, characteristics=sizes)


def _kept(inputs: Inputs, own: OwnContour | None, edge_state: Known | None) -> InForce | None:
    """Returns what is in force of an unmeasured edge; None: the given program cut it. Raises CMP-CUT-WITH."""
    mine = inputs_of_edge(inputs, own)
    if not mine.measured_finished:
        return None
    force = (mine if edge_state is None else edge_state(mine, own)).in_force
    force.require_stated()
    return force if force.record is not None else None


def _setup(
    of: SetupCuts, edges: tuple[EdgeCorrection, ...], program: bytes | None, record: str, name: str
) -> SetupCorrection:
    whole, source = of.cuts[0][1], of.program
    run = (source.file_name, source.source, edges, program, record, name)
    return SetupCorrection(whole.part.name, of.frame, of.features, *run, notes=())


def _with_between(
    correction: Correction, own: OwnContour | None, whole: Inputs, drawn: Sequence[Characteristic]
) -> Correction:
    """Returns the correction of an edge with the lengths from its faces to those of other edges in its record."""
    assert own is not None  # of several edges each has its own
    cut = {whole.profile.names[index] for parts in own.parts for index in parts}
    between = tuple(
        characteristic
        for characteristic in drawn
        if characteristic.other and (characteristic.feature in cut) is not (characteristic.other in cut)
    )
    return replace(correction, record=replace(correction.record, between=between))


def _as_joint(
    correction: Correction, program: bytes | None, of: SetupCuts, characteristics: Sequence[Characteristic] | None
) -> Correction:
    """Returns the correction with the program that carries all in place of its own; offsets are entered by hand."""
    source = correction.source_program if program is None else program
    run = correction.source_name if program is None else of.name
    made = replace(correction, corrected_program=source, offsets_program=None, joint_name=run)
    return judged_on_part(made, characteristics) if of.frame.name and characteristics is not None else made


def _composed(inputs: Inputs, corrections: Sequence[tuple[Record, bytes]], joint_id: str) -> bytes | None:
    """Returns the program with all corrections' edits and its mark; None: no edits; `corrections` by edge."""
    if not corrections:
        return None
    program, run = inputs.program, inputs.run
    edits = [edit for record, _ in corrections for edit in edits_of(program, record.changes)]
    source = apply_edits(program, [_mark(inputs, [record for record, _ in corrections], joint_id), *edits])
    paths = [run.of(program.rewritten(own)) for _, own in corrections]
    require_sum(run.of(program), paths, run.of(program.rewritten(source)))
    return source


def _mark(inputs: Inputs, records: Sequence[Record], joint_id: str) -> Edit:
    program = inputs.program
    of_edges = [f"{record.options.get('edge', 'all edges')}: record {record.id}" for record in records]
    of_machine = [] if inputs.machine is None else [inputs.machine.mark]
    lines = [*marks_of_record(joint_id, program.source), *of_machine, *of_edges]
    return insert_heading(program, [program.dialect.comment(line) for line in lines])


def require_sum(before: ToolPath, singles: Sequence[ToolPath], joint: ToolPath) -> None:
    """Refuses a joint path that is not the source's with what each single path changes of it in its place."""
    stretches, done = list[tuple[ToolPath, int, int]](), 0
    changed = [(*one, path) for path in singles for one in _changed(before, path)]
    for first, last, begin, end, path in sorted(changed, key=lambda one: one[:2]):
        if first < done:
            raise not_as_intended(f"two edges' corrections both move the cut of line {before.line[first]}")
        stretches += [(before, done, first), (path, begin, end)]
        done = last
    stretches.append((before, done, len(before)))
    wanted = sum(end - begin for _, begin, end in stretches)
    if len(joint) != wanted:
        raise not_as_intended(f"the joint program makes {len(joint)} moves; its corrections make {wanted}")
    at = 0
    for path, begin, end in stretches:
        moves, at = (np.arange(begin, end), np.arange(at, at + end - begin)), at + end - begin
        verify_written(path, joint, moves, path.end_mm[begin:end], allowed_mm=10**-DECIMALS)


def _changed(source: ToolPath, single: ToolPath) -> Iterator[tuple[int, int, int, int]]:
    """Stretches of the source that a single path has otherwise: first move and one after the last, of either."""
    matcher = SequenceMatcher(None, _rows(source), _rows(single), autojunk=False)
    return (opcode[1:] for opcode in matcher.get_opcodes() if opcode[0] != "equal")


def _rows(path: ToolPath) -> list[tuple[float, ...]]:
    """Returns the kind and end of each move, to a nanometre: nothing of lines or of calls."""
    values = np.column_stack([path.motion, path.end_mm, np.nan_to_num(path.centre_mm), path.sweep_rad])
    return [tuple(row) for row in np.round(values.astype(np.float64), DECIMALS).tolist()]


def _shares(of: SetupCorrection) -> list[Share]:
    return [
        Share(edge.contour, edge.correction, of.frame)
        for edge in of.edges
        if edge.contour is not None and edge.correction is not None
    ]


def _unjudged(
    done: Sequence[SetupCorrection], characteristics: Sequence[Characteristic], sizes: Sequence[Judged], from_face: bool
) -> list[str]:
    """Describes the sizes that are of no set-up alone and not judged, and why."""
    judged = {size.characteristic.name for size in sizes}
    names = [
        characteristic.name
        for characteristic in characteristics
        if characteristic.name not in judged and not _of_one(characteristic, done)
    ]
    if not names:
        return []
    if from_face:
        return [wording("{names}: sizes of no single set-up, which are not judged.", names=all_of(names))]
    return [
        wording(
            "{names}: sizes of no single set-up, which are not judged: z counts from no face, and on which face the "
            "part stands is not known.",
            names=all_of(names),
        )
    ]


def _of_one(characteristic: Characteristic, done: Sequence[SetupCorrection]) -> bool:
    return any({characteristic.feature, characteristic.other} - {""} <= {*correction.features} for correction in done)


def _left(uncut: Sequence[str]) -> list[str]:
    if not uncut:
        return []
    return [wording("{features}: cut in no set-up, left as they are.", features=all_of(uncut))]


def _by_what_may_be(of: SetupCuts, every: Sequence[SetupCuts]) -> SetupCuts:
    """Returns the set-up with why an offset may not be entered: shared with another set-up, or Z mirrored."""
    machine = of.cuts[0][1].machine_tool
    others = [one for one in every if one is not of and _may_be_one(machine, one.cuts[0][1].machine_tool)]
    shared = {call: one.frame.name for one in others for call in one.calls}
    return replace(of, cuts=tuple((own, _without_offset(own, inputs, of.frame, shared)) for own, inputs in of.cuts))


def _may_be_one(machine: Machine | None, other: Machine | None) -> bool:
    """Returns whether two set-ups may be of one machine: no name or serial number of both is stated to differ."""
    if machine is None or other is None:
        return True
    stated = ((machine.name, other.name), (machine.serial, other.serial))
    return not any(one and two and one != two for one, two in stated)


def require_offset(own: OwnContour, frame: SetupFrame, shared: Mapping[CalledOffset, str], file: str | None) -> None:
    """Raises SET-OFFSET where no offset may be entered; `shared`: by tool the other set-up that cuts with it."""
    if why := _no_offset(own.edge, frame, shared):
        with in_file(file):
            raise Code.SET_OFFSET.refusal(
                f"set-up '{frame.name}': {why.removesuffix('.')}",
                hint='correct by the contour with `trueloop compensate`, without `compensation.by = "offset"`',
                values={"setup": frame.name, "tool": own.edge.called.words},
            )


def _no_offset(edge: CuttingEdge, frame: SetupFrame, shared: Mapping[CalledOffset, str]) -> str:
    """Returns why no offset of an edge may be entered; "": one may."""
    if frame.mirrored_z:
        return wording("{tool}: the control mirrors Z, so that the sign of an offset is not known.", tool=edge.words)
    if edge.called in shared:
        return wording(
            "{tool} cuts in set-up {other} too: its offset would move both, unless `programs.machine` of each names "
            "another machine.",
            tool=edge.words,
            other=shared[edge.called],
        )
    return ""


def _without_offset(
    own: OwnContour | None, inputs: Inputs, frame: SetupFrame, shared: Mapping[CalledOffset, str]
) -> Inputs:
    if own is None:  # a job of set-ups lists its tools
        return inputs
    if inputs.options.by == "offset":
        require_offset(own, frame, shared, inputs.file)
    return replace(inputs, no_offset=_no_offset(own.edge, frame, shared))
