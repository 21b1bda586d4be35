"""Which edge of a job cuts what of its part: every edge with a contour of its own, found from the finish program."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from trueloop.errors import Code, TrueloopError, in_file
from trueloop.geometry.feature import Feature
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.commanded import Run
from trueloop.nc.match.contour_match import FeatureMatch
from trueloop.nc.match.cutters import Cutters, cutters
from trueloop.nc.match.cutting_edge import CuttingEdge
from trueloop.nc.match.matching import match_each
from trueloop.nc.match.own_contour import OwnContour, own_contour
from trueloop.nc.match.tip import of_centre, tip_mm
from trueloop.nc.program.called import Called, called
from trueloop.nc.program.feed_moves import feed_moves
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath


def cutters_of(
    program: Program, run: Run, profile: Profile, edges: Sequence[CuttingEdge], decided: Mapping[str, Called | None]
) -> Cutters:
    """The edge of every feature, or why it is not known. Raises NC errors of running, NC-NO-TOOL for an edge that the
    program does not call.
    """
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
    """The path of the edge's nose."""
    return of_centre(path, tip_mm(program.dialect, edge.tip, edge.nose_radius_mm))


def calls_of(program: Program, run: Run) -> frozenset[Called]:
    """All tool offsets that a program cuts with. Raises NC errors of running."""
    path = run.of(program)
    return _known({move.index: called(program.dialect, path, move.index) for move in feed_moves(path)})


def _known(calls: Mapping[int, Called | None]) -> frozenset[Called]:
    return frozenset(call for call in calls.values() if call is not None)


def contours_of(
    program: Program, run: Run, profile: Profile, edges: Sequence[CuttingEdge], decided: Mapping[str, Called | None]
) -> tuple[OwnContour, ...]:
    """What each edge cuts, in the job's order, without edges that cut nothing of the profile. Raises NC errors."""
    found = cutters_of(program, run, profile, edges, decided)
    with in_file(program.file):
        cutting = set(found.edge_of)
    return tuple(own_contour(profile, found, edge) for edge in edges if edge in cutting)


@dataclass(frozen=True)
class CutFeature:
    """A feature as an edge cuts it, by name (of several that one move cuts, all), or why that is not known.

    `tool` is what the program calls there; "" before any T word or where it is not known. `match` None: left alone.
    """

    feature: Feature
    tool: str
    match: FeatureMatch | TrueloopError | None


def cut_features(
    program: Program, run: Run, profile: Profile, edges: Sequence[CuttingEdge], decided: Mapping[str, Called | None]
) -> list[CutFeature]:
    """Every feature of a job of several edges, in the profile's order. Raises NC-NO-TOOL and what running raises."""
    return cut_as_found(program, run, profile, cutters_of(program, run, profile, edges, decided))


def cut_as_found(program: Program, run: Run, profile: Profile, found: Cutters) -> list[CutFeature]:
    """The same where the edges of the features are known."""
    path = run.of(program)
    cut = {
        index: CutFeature(feature, "", one)
        for index, (feature, one) in enumerate(zip(profile.features, found.found, strict=True))
        if not isinstance(one, CuttingEdge)
    }
    for edge in dict.fromkeys(one for one in found.found if isinstance(one, CuttingEdge)):
        own = own_contour(profile, found, edge)
        moves = replace(run, called=edge.called).moves(program, _of_centre(program, path, edge))
        matches = match_each(moves, own.profile, edge.nose_radius_mm, lines=run.lines)
        for parts, feature, match in zip(own.parts, own.profile.features, matches, strict=True):
            cut[parts[0]] = CutFeature(feature, edge.words, match)
    return [cut[index] for index in sorted(cut)]


def cut_by_one(program: Program, run: Run, profile: Profile, nose_radius_mm: float) -> list[CutFeature]:
    """The same of a job of one tool, whatever the program calls."""
    path = run.of(program)
    seen = of_centre(path, tip_mm(program.dialect, run.tip or 0, nose_radius_mm))
    matches = match_each(feed_moves(seen), profile, nose_radius_mm, lines=run.lines)
    pairs = zip(profile.features, matches, strict=True)
    return [CutFeature(feature, _tool_of(program, path, match), match) for feature, match in pairs]


def _tool_of(program: Program, path: ToolPath, match: FeatureMatch | TrueloopError) -> str:
    call = None if isinstance(match, TrueloopError) else called(program.dialect, path, match.moves[0].move.index)
    return "" if call is None else call.words


def _uncalled(edge: CuttingEdge, known: Sequence[Called]) -> TrueloopError:
    there = f"those of its cuts are {', '.join(one.words for one in known)}" if known else "it calls none at all"
    return TrueloopError(
        Code.NC_NO_TOOL,
        f"the job has a tool {edge.called.words}, which the program does not cut with: {there}",
        hint="`number` of [[tools]] is that of the tool's offset: 12 of T0312, H12; on a Sinumerik T, `table_edge` D",
        values={"tool": edge.called.words},
    )
