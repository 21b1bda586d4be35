"""The features that each edge of each set-up cuts, determined from the finish programs: every edge with a contour of
its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.geometry.feature import Feature
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.loops.turned.commanded import Run
from trueloop.nc.match.cutters import Cutters, CuttingEdge, cutters, of_centre, tip_mm
from trueloop.nc.match.matching import FeatureMatch, match_each
from trueloop.nc.match.own_contour import OwnContour, own_contour
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.called import CalledOffset, called
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.wording import wording

MORE: Final = 1.1
"""A program that runs along more of the part by so much with its Z the other way round was written that way."""


def cutters_of(
    program: Program,
    run: Run,
    profile: Profile,
    edges: Sequence[CuttingEdge],
    decided: Mapping[str, CalledOffset | None],
) -> Cutters:
    """Returns the edge of every feature, or why it is not known. Raises NC errors, NC-NO-TOOL for an uncalled edge."""
    path = run.of(program)
    calls = {move.index: called(program.dialect, path, move.index) for move in feed_moves(path)}
    known = sorted(_known(calls))
    for edge in edges:
        if edge.called not in known:
            with in_file(program.file):
                raise _uncalled(edge, known)
    of_edge = [
        [move for move in feed_moves(_of_centre(program, path, edge)) if calls[move.index] == edge.called]
        for edge in edges
    ]
    return cutters(profile, of_edge, edges, decided)


def _of_centre(program: Program, path: ToolPath, edge: CuttingEdge) -> ToolPath:
    """Returns the path of the edge's nose."""
    return of_centre(path, tip_mm(program.dialect, edge.tip, edge.nose_radius_mm))


def _known(calls: Mapping[int, CalledOffset | None]) -> frozenset[CalledOffset]:
    return frozenset(call for call in calls.values() if call is not None)


@dataclass(frozen=True)
class CutFeature:
    """A feature as an edge cuts it, by name (of several that one move cuts, all), or why that is not known.

    `tool` is what the program calls there; "" before any T word or where it is not known. `match` None: left alone.
    """

    feature: Feature
    tool: str
    match: FeatureMatch | TrueloopError | None


def _cut_as_found(program: Program, run: Run, profile: Profile, cutters: Cutters) -> list[CutFeature]:
    """Returns every feature of a job of several edges, in the profile's order. Raises NC errors of running."""
    path = run.of(program)
    cut = {
        index: CutFeature(feature, "", one)
        for index, (feature, one) in enumerate(zip(profile.features, cutters.found, strict=True))
        if not isinstance(one, CuttingEdge)
    }
    for edge in dict.fromkeys(one for one in cutters.found if isinstance(one, CuttingEdge)):
        own = own_contour(profile, cutters, edge)
        moves = replace(run, called=edge.called).moves(program, _of_centre(program, path, edge))
        matches = match_each(moves, own.profile, edge.nose_radius_mm, lines=run.lines)
        for parts, feature, match in zip(own.parts, own.profile.features, matches, strict=True):
            cut[parts[0]] = CutFeature(feature, edge.words, match)
    return [cut[index] for index in sorted(cut)]


def _tool_of(program: Program, path: ToolPath, match: FeatureMatch | TrueloopError) -> str:
    call = None if isinstance(match, TrueloopError) else called(program.dialect, path, match.moves[0].move.index)
    return "" if call is None else call.words


def _uncalled(edge: CuttingEdge, offsets: Sequence[CalledOffset]) -> TrueloopError:
    there = (
        f"those of its cuts are {', '.join(offset.words for offset in offsets)}" if offsets else "it calls none at all"
    )
    return Code.NC_NO_TOOL.refusal(
        wording(
            "the job has a tool {tool}, which the program does not cut with: {there}",
            tool=edge.called.words,
            there=there,
        ),
        hint="`number` of [[tools]] is that of the tool's offset: 12 of T0312, H12; on a Sinumerik T, `table_edge` D",
        values={"tool": edge.called.words},
    )


@dataclass(frozen=True)
class Setup:
    """One set-up: its frame, its finish program, and the edges that it cuts with. `decided`: by feature an edge that
    the job names, of features that are decided to be this set-up's. `nose_radius_mm` is that of a job's only tool,
    which cuts the whole profile whatever the program calls; then there are no `edges`.
    """

    frame: SetupFrame
    program: Program
    run: Run
    edges: tuple[CuttingEdge, ...]
    decided: Mapping[str, CalledOffset | None]
    nose_radius_mm: float | None = None


@dataclass(frozen=True)
class OfSetup:
    """The cut of one set-up: `features` by name, in order; `found` of its `profile`; None: the only tool cuts all."""

    setup: Setup
    profile: Profile
    features: tuple[str, ...]
    found: Cutters | None

    @property
    def contours(self) -> tuple[OwnContour | None, ...]:
        """Returns the contours of its cutting edges, in the job's order; None: the only tool's. Raises NC errors."""
        if self.found is None:
            return (None,)
        with in_file(self.setup.program.file):
            cutting = set(self.found.edge_of)
        return tuple(own_contour(self.profile, self.found, edge) for edge in self.setup.edges if edge in cutting)

    @property
    def calls(self) -> frozenset[CalledOffset]:
        """Returns all tool offsets that its program cuts with. Raises NC errors of running."""
        path = self.setup.run.of(self.setup.program)
        return _known({move.index: called(self.setup.program.dialect, path, move.index) for move in feed_moves(path)})

    @property
    def cut_features(self) -> list[CutFeature]:
        """Returns its features with the moves that cut them, in the frame's order; without those left to others."""
        one = self.setup
        if self.found is None:
            assert one.nose_radius_mm is not None
            # Features cut by the job's only tool; T words are ignored
            path = one.run.of(one.program)
            seen = of_centre(path, tip_mm(one.program.dialect, one.run.tip or 0, one.nose_radius_mm))
            matches = match_each(feed_moves(seen), self.profile, one.nose_radius_mm, lines=one.run.lines)
            pairs = zip(self.profile.features, matches, strict=True)
            return [CutFeature(feature, _tool_of(one.program, path, match), match) for feature, match in pairs]
        found = _cut_as_found(one.program, one.run, self.profile, self.found)
        return [cut for cut in found if cut.match is not None] if one.frame.name else found


@dataclass(frozen=True)
class InSetups:
    """A part's features by set-up. `uncut`: names; `doubtful`: why a feature that several cut belongs to none."""

    setups: tuple[OfSetup, ...]
    uncut: tuple[str, ...]
    doubtful: tuple[TrueloopError, ...]

    def require_plain(self) -> None:
        """Raises SET-FEATURE for the first feature that several set-ups cut."""
        for refusal in self.doubtful:
            raise refusal


def in_setups(profile: Profile, setups: Sequence[Setup], decided: Mapping[str, str | None]) -> InSetups:
    """Determines the features of each set-up. `decided`: by feature the name of the set-up that leaves its surface,
    where the job states it; None: it is to be left alone. A job without set-ups has one, in the part's frame, whose
    name is empty.

    Raises SET-CUTS for a set-up that cuts nothing of the part, SET-MIRROR for one whose program fits it with Z the
    other way round, NC-NO-TOOL, and NC errors of running.
    """
    if not setups[0].frame.name:
        (only,) = setups
        cut_by_tool = None if only.nose_radius_mm is not None else _found(profile, only)[2]
        return InSetups((OfSetup(only, profile, profile.names, cut_by_tool),), (), ())
    found = [_found(profile, setup) for setup in setups]
    for setup, placed, cut_by in found:
        _require_direction(profile, setup, placed, cut_by)
    cut_in = {name: _decided(decided[name]) if name in decided else _cut_in(name, found) for name in profile.names}
    of_setups = tuple(
        _of_setup(setup, placed, cutters, tuple(name for name in profile.names if cut_in[name] == [setup.frame.name]))
        for setup, placed, cutters in found
    )
    for of_setup in of_setups:
        name = of_setup.setup.frame.name
        if not any(name in where for where in cut_in.values()):
            raise _cuts_nothing(of_setup.setup, f"all that set-up '{name}' cuts is decided to be another's")
    return InSetups(
        of_setups,
        tuple(name for name, where in cut_in.items() if not where),
        tuple(_several(name, where) for name, where in cut_in.items() if len(where) > 1),
    )


_Found = tuple[Setup, Profile, Cutters]


def _found(profile: Profile, setup: Setup) -> _Found:
    placed = setup.frame.profile(profile) if setup.frame.name else profile
    return setup, placed, cutters_of(setup.program, setup.run, placed, setup.edges, setup.decided)


def _decided(setup: str | None) -> list[str]:
    return [] if setup is None else [setup]


def _cut_in(feature: str, founds: Sequence[_Found]) -> list[str]:
    return [setup.frame.name for setup, placed, cutters in founds if cutters.cuts(placed.names.index(feature))]


def _of_setup(setup: Setup, placed: Profile, cutters: Cutters, features: tuple[str, ...]) -> OfSetup:
    """Returns the cuts of one set-up; features that other set-ups cut, or none, have no cutter here."""
    own = tuple(one if name in features else None for name, one in zip(placed.names, cutters.found, strict=True))
    return OfSetup(setup, placed, features, replace(cutters, found=own))


def _along_mm(profile: Profile, cutters: Cutters) -> float:
    """Returns how much of the part's profile the program runs along."""
    return sum(cutters.share(index) * feature.length_mm for index, feature in enumerate(profile.features))


def _require_direction(profile: Profile, setup: Setup, placed: Profile, cutters: Cutters) -> None:
    """Refuses a program that contradicts the stated direction of Z, which is not guessed."""
    frame, stated_mm = setup.frame, _along_mm(placed, cutters)
    _, other_way, there = _found(profile, replace(setup, frame=frame.the_other_way))
    other_mm = _along_mm(other_way, there)
    with in_file(setup.program.file):
        if other_mm > MORE * stated_mm:
            raise _mirrored(frame, stated_mm, other_mm)
        if not stated_mm:
            said = f"the program of set-up '{frame.name}' runs along nothing of the part, whichever way its Z points"
            raise _cuts_nothing(setup, f"{said}: {frame.words} is stated")


def _cuts_nothing(setup: Setup, reason: str) -> TrueloopError:
    return Code.SET_CUTS.refusal(
        reason,
        hint="mend its `setups.zero_at_z_mm`, z of the part where this program's Z is 0, or its tools, or leave it out",
        place=Place(setup.program.file),
        values={"setup": setup.frame.name},
    )


def _mirrored(frame: SetupFrame, stated_mm: float, other_mm: float) -> TrueloopError:
    mend = (
        f"leave out `{'flipped' if frame.flipped else 'mirrored_z'}` of the set-up"
        if frame.backwards
        else "state in its table [[setups]] `flipped = true` where the part is turned round, `mirrored_z = "
        "true` where the "
        "control mirrors Z"
    )
    return Code.SET_MIRROR.refusal(
        wording(
            "the program of set-up '{setup}' runs along {stated_mm:.3f} mm of the part's profile as stated "
            "({stated}), and along {other_mm:.3f} mm with its Z the other way round ({other})",
            setup=frame.name,
            stated_mm=stated_mm,
            stated=frame.words,
            other_mm=other_mm,
            other=frame.the_other_way.words,
        ),
        hint=f"{mend}; or mend its `setups.zero_at_z_mm`",
        values={"setup": frame.name},
    )


def _several(feature: str, setups: Sequence[str]) -> TrueloopError:
    return Code.SET_FEATURE.refusal(
        wording(
            "'{feature}' is cut in {n} set-ups: {setups}", feature=feature, n=len(setups), setups=" and ".join(setups)
        ),
        hint=f'state which one leaves the surface: [feature.{feature}] setup = "{setups[-1]}"; where each leaves a '
        "part of it, make two features of it",
        values={"feature": feature, "setups": list(setups)},
    )
