"""The commands of the programs on the part: the contour's own deviation d from the nominal, before any error.

What is corrected is what was commanded: if the semi-finish program's contour itself deviates from the nominal (a mock
error, a slip), the touches contain it, and the process must not be blamed for it.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.geometry.feature import Feature, Point
from trueloop.geometry.profile import Profile, Side
from trueloop.loops.turned.deviations import (
    SAMPLES,
    conditions_words,
    depth_words,
    of_contour,
    of_surface,
    of_written,
    unevenness_mm,
)
from trueloop.loops.turned.in_force import NOTHING, InForce
from trueloop.nc.check.rapid import sides_of_cuts
from trueloop.nc.match.contour import ProgramContour, contour_of_program
from trueloop.nc.match.cutters import CENTRE, ORIENTATIONS, of_centre, require_side, tip_mm
from trueloop.nc.match.matching import ContourMatch, match_contour
from trueloop.nc.program.along import FeedMove, feed_moves, path_mode_findings
from trueloop.nc.program.called import CalledOffset, CutterTool, called
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import NO_COMPENSATION, ToolPath
from trueloop.nc.program.understood import (
    require_known_frame,
    require_seen,
    require_sound,
    require_understood,
    require_unturned,
)
from trueloop.turned.compensation.shift import ZERO, Shift
from trueloop.turned.compensation.targets import Cut
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import Um, wording


@dataclass(frozen=True)
class Run:
    """The way in which programs are run and read, as a rule with roughing left out: parameters by name, whether blocks
    with a slash are executed, and which lines (from, to) of the finish program hold the finish pass, where that is not
    obvious. `called`: only what that edge cuts counts; None: a program of one. `number`: the finishing tool's, as the
    job states it: of the runs of one contour by several tools its own counts. `tip`: the orientation of the tip that
    programs move without G41 or G42, by the control's number, 0 for the nose's centre; None: determined from the path.
    `accept_unknown_words`: whether a contour is read from a program with words that the dialect does not know.
    """

    parameters: Mapping[str, float]
    execute_deleted_blocks: bool = False
    lines: tuple[int, int] | None = None
    called: CalledOffset | None = None
    number: int | None = None
    tip: int | None = None
    accept_unknown_words: bool = False

    def moves(self, program: Program, path: ToolPath) -> tuple[FeedMove, ...]:
        """Returns the feed moves that count; of those that the same blocks make again at the same places the last."""
        return self._one_run(program, path)[0]

    def again(self, program: Program, path: ToolPath) -> tuple[FeedMove, ...]:
        """Returns those that the same blocks make at the same places besides."""
        return self._one_run(program, path)[1]

    def _one_run(self, program: Program, path: ToolPath) -> tuple[tuple[FeedMove, ...], tuple[FeedMove, ...]]:
        def call(move: FeedMove) -> CalledOffset | None:
            return called(program.dialect, path, move.index)

        moves = feed_moves(path)
        if self.called is not None:
            moves = tuple(move for move in moves if call(move) == self.called)
        return of_one_run(moves, lambda move: (own := call(move)) is not None and own.number == self.number)

    def driven(self, program: Program, nose_radius_mm: float) -> ToolPath:
        """Returns the nose centre's path as the control drives it under G41 and G42; obstacles are findings."""
        nose, skipped_blocks = CutterTool(nose_radius_mm, tip=0), self.execute_deleted_blocks
        return program.run(self.parameters, skipped_blocks=skipped_blocks, tools=[nose], strict=False, roughing=False)

    def with_roughing(self, program: Program) -> ToolPath:
        """Returns the tool path with the cuts of roughing cycles; those that cannot be followed are left out."""
        return program.run(self.parameters, skipped_blocks=self.execute_deleted_blocks, strict=False)

    def of(self, program: Program) -> ToolPath:
        """Returns the tool path of a program. Raises NC errors with the program's file named."""
        with in_file(program.file):
            path = program.run(self.parameters, skipped_blocks=self.execute_deleted_blocks, roughing=False)
            require_known_frame(path)  # first: read with the wrong X, arcs are none
            require_sound(path)
            return path

    def contour(self, program: Program, nose_radius_mm: float, side: Side = Side.OUTSIDE) -> ProgramContour:
        """Returns the contour that a finish pass leaves. Raises NC and GEO errors with the program's file named."""
        with in_file(program.file):
            if not self.accept_unknown_words:
                require_understood(program)
            path = program.run(self.parameters, skipped_blocks=self.execute_deleted_blocks, roughing=False)
            path = of_centre(path, tip_mm(program.dialect, self.tip or 0, nose_radius_mm))
            shown = sides_of_cuts(path)
            return contour_of_program(
                feed_moves(path), nose_radius_mm, lines=self.lines, side=side, shown=shown, tip=self.tip or 0
            )


@dataclass(frozen=True)
class Commanded:
    """The finish program run and matched, with the deviations that matter by feature.

    `tip` is the orientation of the tip that the finish program moves, by the control's number, and `tip_mm` where it
    lies from the nose's centre (x, z); 0 and no distance where it moves the centre or, under G41 and G42, the contour.
    `finish` is by what the finish program's contour deviates from the nominal. `rounding` is that of it which is no
    more than the control resolves, and is kept; zero where it is more, which is corrected away. `measured` is what the
    surface that was touched was commanded to deviate by; zero where that is rounding. `in_force` is by what the
    corrected program that was in force deviates; empty: none was. `unevenness_mm` is by how much the finish program's
    short lines deviate from the curves that they are chords of; 0 where it has none. `by_other`: in words, that another
    tool cut the measured surface than finishes it; "": none, as far as it is known.
    """

    path: ToolPath
    match: ContourMatch
    tip: int
    tip_mm: Point
    finish: tuple[Shift, ...]
    rounding: tuple[Shift, ...]
    measured: tuple[Shift, ...]
    in_force: tuple[Shift, ...]
    resolution_mm: float
    unevenness_mm: float
    notes: tuple[str, ...]
    by_other: str = ""

    @property
    def cuts(self) -> tuple[Cut, ...]:
        """Returns the moves that cut the contour, in program order."""
        cuts = [
            Cut(m.move.index, i, m.start_mm, m.end_mm)
            for i, feature in enumerate(self.match.features)
            for m in feature.moves
        ]
        return tuple(sorted(cuts, key=lambda cut: cut.move))

    def measured_at(self, touches: ErrorVectors) -> Array:
        """Returns the commanded deviation at each touch, (n,)."""
        return self.measured_along(touches.feature_index, touches.arc_length_mm)

    def measured_along(self, feature_index: Integers, arc_length_mm: Array) -> Array:
        """Returns the commanded deviation at places of the profile, (n,)."""
        pairs = zip(feature_index.tolist(), arc_length_mm, strict=True)
        return np.array([float(self.measured[i].value_mm(s)) for i, s in pairs])


def commanded(
    program: Program,
    semifinish: Program | None,
    profile: Profile,
    nose_radius_mm: float,
    allowance_mm: float,
    run: Run,
    force: InForce = NOTHING,
) -> Commanded:
    """Runs the programs and lays them on the profile. Raises NC errors of running and matching.

    Without a semi-finish program the finish program's own deviation is taken for that of the measured surface. The
    contour of a corrected program in force is not a deviation: it is kept, and errors are counted from it.
    """
    path = run.of(program)
    match, tip = _matched(program, path, run, profile, nose_radius_mm, 0.0)
    other, conditions, by_other = match, list[str](), ""
    if semifinish is not None:
        before = run.of(semifinish)
        called_there = run.called if run.moves(semifinish, before) else None
        own = replace(run, called=called_there, lines=None)
        other, tip_before = _matched(semifinish, before, own, profile, nose_radius_mm, allowance_mm)
        by_other = _by_other((program, path, match), (semifinish, before, other))
        roughed = of_centre(run.with_roughing(semifinish), tip_mm(semifinish.dialect, tip_before, nose_radius_mm))
        conditions = [*conditions_words(path, match, before, other), *depth_words(match, other, feed_moves(roughed))]
    elif force.program is not None:
        before = run.of(force.program)
        other, _ = _matched(force.program, before, replace(run, lines=force.lines), profile, nose_radius_mm, 0.0)
    resolution_mm = program.dialect.step_mm(bool(path.inch[match.features[0].moves[0].move.index]))
    with in_file(program.file):
        corrected = [m.move.index for feature in match.features for m in feature.moves]
        require_unturned(path, corrected)
        require_seen(program, path, corrected, "XZ")
    finish = tuple(of_contour(feature, resolution_mm) for feature in match.features)
    measured = tuple(map(of_surface, other.features))
    slips = [_peak_mm(f, d) > resolution_mm for f, d in zip(profile.features, finish, strict=True)]
    meant = [_peak_mm(f, d) > resolution_mm for f, d in zip(profile.features, measured, strict=True)]
    kept = force.program is not None
    radius_is_compensated = bool(np.all(path.compensation[corrected] != NO_COMPENSATION))
    return Commanded(
        path=path,
        match=match,
        tip=tip,
        by_other=by_other,
        tip_mm=tip_mm(program.dialect, tip, nose_radius_mm),
        finish=finish,
        rounding=tuple(ZERO if real else d for d, real in zip(finish, slips, strict=True)),
        measured=tuple(d if real and not kept else ZERO for d, real in zip(measured, meant, strict=True)),
        in_force=tuple(of_written(feature, resolution_mm) for feature in other.features) if kept else (),
        resolution_mm=resolution_mm,
        unevenness_mm=max(map(unevenness_mm, match.features, finish)),
        notes=(
            *_run_again(program, path, match, run),
            *([] if radius_is_compensated else _tip_words(program, tip, nose_radius_mm)),
            *(f"{found.message}; {found.hint}." for found in path_mode_findings(program, path)),
            *_notes(profile, finish, slips, wording("finish")),
            *conditions,
            *(_notes(profile, measured, meant, wording("semi-finish")) if semifinish is not None else ()),
        ),
    )


def _run_again(program: Program, path: ToolPath, match: ContourMatch, run: Run) -> list[str]:
    """Returns a note on the passes that run on the contour's blocks besides: they move with it."""
    cutting = [matched.move for feature in match.features for matched in feature.moves]
    lines = {move.line for move in cutting}
    beside = [move for move in run.again(program, path) if move.line in lines]
    if not beside:
        return []
    calls = {called(program.dialect, path, move.index) for move in beside}
    other = sorted({call.words for call in calls if call} - {_words(program, path, cutting[0])})
    note = wording(
        "The blocks of the contour run {count} times: every run moves with the correction.",
        count=1 + max(Counter(move.line for move in beside).values()),
    )
    if not other:
        return [note]
    mine = _words(program, path, cutting[0])
    return [note, wording("{others} cut it too, before or after {mine}.", others=", ".join(other), mine=mine)]


def _words(program: Program, path: ToolPath, move: FeedMove) -> str:
    call = called(program.dialect, path, move.index)
    return "" if call is None else call.words


def _by_other(
    finish: tuple[Program, ToolPath, ContourMatch], semifinish: tuple[Program, ToolPath, ContourMatch]
) -> str:
    """Returns that another tool cut the measured surface than finishes it; "": none, as far as both are called."""
    finishing, semifinishing = (
        [called(program.dialect, path, one.moves[0].move.index) for one in match.features]
        for program, path, match in (finish, semifinish)
    )
    for feature, tool, before in zip(finish[2].features, finishing, semifinishing, strict=True):
        if tool is not None and before is not None and tool != before:
            return wording(
                "{feature} was semi-finished with the offset {was} and is finished with {now}: errors of the setting "
                "of {was} are not those of {now}, so that no offset of {now} is proposed.",
                feature=feature.feature.name,
                was=before.words,
                now=tool.words,
            )
    return ""


def _matched(
    program: Program, path: ToolPath, run: Run, profile: Profile, nose_radius_mm: float, allowance_mm: float
) -> tuple[ContourMatch, int]:
    """Returns the match, and the orientation of the tip that the program moves.

    Where the job does not state it and no pass is one of the nose's centre, of the contour neither: the only tip whose
    path fits.
    """

    def by(tip: int) -> ContourMatch:
        seen = of_centre(path, tip_mm(program.dialect, tip, nose_radius_mm))
        moves = run.moves(program, seen)
        match = match_contour(moves, profile, nose_radius_mm, allowance_mm=allowance_mm, lines=run.lines)
        require_side(match, sides_of_cuts(seen))
        return match

    with in_file(program.file):
        try:
            return by(run.tip or 0), run.tip or 0
        except TrueloopError as refused:
            if refused.code is not Code.NC_NO_MATCH or run.tip is not None or nose_radius_mm == 0.0:
                raise
            fitting = list(_fitting(by))
            if len(fitting) != 1:
                raise
            return fitting[0]


def _fitting(by: Callable[[int], ContourMatch]) -> Iterator[tuple[ContourMatch, int]]:
    for tip in ORIENTATIONS:
        try:
            match = by(tip)
        except TrueloopError:
            continue
        if not match.on_contour:
            yield match, tip


def _tip_words(program: Program, tip: int, nose_radius_mm: float) -> list[str]:
    """Returns a note on a program that moves the imaginary tip."""
    if tip_mm(program.dialect, tip, nose_radius_mm) == CENTRE:
        return []
    x_mm, z_mm = tip_mm(program.dialect, tip, nose_radius_mm)
    return [
        wording(
            "The program moves the imaginary tip of orientation {tip}, X {x:+.4f} mm (radius), Z {z:+.4f} mm off the "
            "nose's centre, without G41 or G42: the corrected one does, too.",
            tip=tip,
            x=x_mm,
            z=z_mm,
        )
    ]


def _peak_mm(feature: Feature, deviation: Shift) -> float:
    return float(np.max(np.abs(deviation.value_mm(np.linspace(0.0, feature.length_mm, SAMPLES)))))


def _notes(profile: Profile, deviations: tuple[Shift, ...], real: list[bool], program: str) -> list[str]:
    return [
        wording(
            "The {program} program's own contour stands up to {off} off the nominal on {feature}: that is not blamed "
            "on the process.",
            program=program,
            off=Um(_peak_mm(feature, deviation)),
            feature=feature.name,
        )
        for feature, deviation, it_is in zip(profile.features, deviations, real, strict=True)
        if it_is
    ]


SAME_PLACE_MM: Final = 1e-6


def of_one_run(
    moves: Sequence[FeedMove], stated: Callable[[FeedMove], bool]
) -> tuple[tuple[FeedMove, ...], tuple[FeedMove, ...]]:
    """Returns the feed moves without the chains that their lines repeat at equal places, and the moves left out.

    Of repeated chains the last by the job's tool (`stated`) counts, else the last of all: it leaves the surface.
    The way to the first end may differ.
    """
    chains = [list(members) for _, members in groupby(moves, key=lambda move: move.chain)]
    counts: dict[tuple[object, ...], int] = {}
    for place, chain in enumerate(chains):
        key = tuple(map(_key, chain))
        before = counts.get(key)
        if before is None or stated(chain[0]) or not stated(chains[before][0]):
            counts[key] = place
    kept = set(counts.values())
    taken, left = (
        tuple(move for place, chain in enumerate(chains) if (place in kept) is wanted for move in chain)
        for wanted in (True, False)
    )
    return taken, left


def _key(move: FeedMove) -> tuple[object, ...]:
    x, z = (round(value / SAME_PLACE_MM) for value in move.path.end_mm)
    return move.line, x, z, move.compensation
