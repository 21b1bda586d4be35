"""The corrections of a part's set-ups, from one inspection: each program corrected and read back by itself."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.judged import Judged
from trueloop.domain.record import record_id
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.edges import calls_of
from trueloop.loops.turned.in_setup import judged_on_part
from trueloop.loops.turned.joint import Joint, correct_edges
from trueloop.loops.turned.setup_sizes import setup_sizes
from trueloop.loops.turned.setups import InSetups, OfSetup, Setup
from trueloop.loops.turned.shared_sizes import Share
from trueloop.nc.match.own_contour import OwnContour
from trueloop.nc.program.called import Called
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import all_of, wording


@dataclass(frozen=True)
class CutsOfSetup:
    """A set-up with the inputs of each of its edges, in its frame; `name` is that of the file that carries all."""

    of: OfSetup
    cuts: tuple[tuple[OwnContour, Inputs], ...]
    name: str


@dataclass(frozen=True)
class CorrectedSetup:
    """A set-up, the program that carries its corrections, and the name of its file."""

    frame: SetupFrame
    features: tuple[str, ...]
    joint: Joint
    name: str


@dataclass(frozen=True)
class CorrectedSetups:
    """The corrections of all set-ups of a part; `profile` is the part's. `record_id` is of the joints' own ids.
    `characteristics` are those between faces of two set-ups.
    """

    part: str
    profile: Profile
    setups: tuple[CorrectedSetup, ...]
    uncut: tuple[str, ...]
    record_id: str
    notes: tuple[str, ...]
    characteristics: tuple[Judged, ...] = ()


def correct_setups(
    profile: Profile,
    found: InSetups,
    cuts: Sequence[CutsOfSetup],
    asked: Sequence[Characteristic],
    vectors: ErrorVectors,
    notes: Sequence[str],
    known: Callable[[Inputs, OwnContour], Inputs] | None = None,
) -> CorrectedSetups:
    """Corrects every program: all of them, or none. `asked` are the part's characteristics, `vectors` what was measured
    of it, in its frame. `known` adds to the inputs of one edge what is known of it.

    Raises what correcting one raises, and SET-OFFSET where the job wants an offset that cannot be entered.
    """
    kept = [replace(one, cuts=_by_what_may_be(one, cuts)) for one in cuts]
    done = tuple(_corrected(one, asked, known) for one in kept)
    whole = kept[0].cuts[0][1]
    allowed = any(of.allowance_mm or of.measured_allowance_mm for one in kept for _, of in one.cuts)
    sizes = () if allowed else setup_sizes(profile, asked, vectors, [_shares(one) for one in done])
    return CorrectedSetups(
        part=whole.part.name,
        profile=profile,
        setups=done,
        uncut=found.uncut,
        record_id=record_id(dict(whole.inputs_sha256), {"setups": [one.joint.record_id for one in done]}),
        notes=(*_left(found), *notes, *_unjudged(done, asked, sizes, bool(vectors.at_reference.any()))),
        characteristics=sizes,
    )


def _shares(of: CorrectedSetup) -> list[Share]:
    return [Share(one.contour, one.correction, of.frame) for one in of.joint.edges if one.correction is not None]


def _unjudged(
    done: Sequence[CorrectedSetup], asked: Sequence[Characteristic], sizes: Sequence[Judged], from_face: bool
) -> list[str]:
    """The sizes that are of no set-up alone and not judged, in words, and why."""
    judged = {one.characteristic.name for one in sizes}
    names = [one.name for one in asked if one.name not in judged and not _of_one(one, done)]
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


def _of_one(asked: Characteristic, done: Sequence[CorrectedSetup]) -> bool:
    return any({asked.feature, asked.other} - {""} <= {*one.features} for one in done)


def _corrected(
    of: CutsOfSetup, asked: Sequence[Characteristic], known: Callable[[Inputs, OwnContour], Inputs] | None
) -> CorrectedSetup:
    joint = correct_edges(of.cuts, of.name, known)
    edges = tuple(replace(e, correction=e.correction and judged_on_part(e.correction, asked)) for e in joint.edges)
    return CorrectedSetup(of.of.setup.frame, of.of.features, replace(joint, edges=edges), of.name)


def _left(found: InSetups) -> list[str]:
    if not found.uncut:
        return []
    return [wording("{features}: cut in no set-up, left as they are.", features=all_of(found.uncut))]


def _by_what_may_be(of: CutsOfSetup, every: Sequence[CutsOfSetup]) -> tuple[tuple[OwnContour, Inputs], ...]:
    """The inputs with why an edge's offset may not be entered at the control."""
    shared = _shared_with(of.of.setup, [one.of.setup for one in every], _machines(every))
    return tuple((own, _without_offset(own, inputs, of.of.setup.frame, shared)) for own, inputs in of.cuts)


def _machines(every: Iterable[CutsOfSetup]) -> Mapping[str, object]:
    """By set-up the machine that it is turned on, None where that is not stated."""
    return {one.of.setup.frame.name: one.cuts[0][1].machine_tool for one in every}


def _shared_with(setup: Setup, every: Sequence[Setup], machines: Mapping[str, object]) -> Mapping[Called, str]:
    """Tool offsets of a set-up by which another one on the same machine cuts too, and the name of that one."""
    name = setup.frame.name
    same = [other for other in every if other is not setup and machines[other.frame.name] == machines[name]]
    return {call: other.frame.name for other in same for call in calls_of(other.program, other.run)}


def _without_offset(own: OwnContour, inputs: Inputs, frame: SetupFrame, shared: Mapping[Called, str]) -> Inputs:
    tool, other = own.edge.words, shared.get(own.edge.called)
    if frame.mirrored_z:
        why = wording("{tool}: the control mirrors Z, so that the sign of an offset is not known.", tool=tool)
    elif other is not None:
        why = wording(
            "{tool} cuts in set-up {other} too: its offset would move both, unless `programs.machine` of each names "
            "another machine.",
            tool=tool,
            other=other,
        )
    else:
        return inputs
    if inputs.options.by == "offset":
        with in_file(inputs.file):
            raise TrueloopError(
                Code.SET_OFFSET,
                f"set-up '{frame.name}': {why.removesuffix('.')}",
                hint='leave out `compensation.by = "offset"`: the contour is corrected then',
                values={"setup": frame.name, "tool": own.edge.called.words},
            )
    return replace(inputs, no_offset=why)
