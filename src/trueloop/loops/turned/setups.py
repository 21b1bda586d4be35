"""Which set-up of a part cuts which of its features, found from the program of each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.edges import CutFeature, cut_as_found, cutters_of
from trueloop.nc.match.cutters import Cutters
from trueloop.nc.match.cutting_edge import CuttingEdge
from trueloop.nc.match.own_contour import OwnContour, own_contour
from trueloop.nc.program.called import Called
from trueloop.nc.program.program import Program

MORE: Final = 1.1
"""A program that runs along more of the part by so much with its Z the other way round was written that way."""


@dataclass(frozen=True)
class Setup:
    """One set-up: its frame, its finish program, and the edges that it cuts with. `decided`: by feature an edge that
    the job names, of features that are decided to be this set-up's.
    """

    frame: SetupFrame
    program: Program
    run: Run
    edges: tuple[CuttingEdge, ...]
    decided: Mapping[str, Called | None]


@dataclass(frozen=True)
class OfSetup:
    """What one set-up cuts: `features` by name, in the part's order; `found` is of `profile`, in the set-up's frame."""

    setup: Setup
    profile: Profile
    features: tuple[str, ...]
    found: Cutters

    @property
    def contours(self) -> tuple[OwnContour, ...]:
        """Those of its edges that cut something. Raises NC errors where the edge of a feature is not known."""
        with in_file(self.setup.program.file):
            cutting = set(self.found.edge_of)
        return tuple(own_contour(self.profile, self.found, edge) for edge in self.setup.edges if edge in cutting)

    @property
    def cut_features(self) -> list[CutFeature]:
        """Its features with the moves that cut them, in the frame's order."""
        found = cut_as_found(self.setup.program, self.setup.run, self.profile, self.found)
        return [one for one in found if one.match is not None]


@dataclass(frozen=True)
class InSetups:
    """The features of a part by set-up. `uncut`: names of those that none cuts; `doubtful`: why a feature is of none,
    though several cut it.
    """

    setups: tuple[OfSetup, ...]
    uncut: tuple[str, ...]
    doubtful: tuple[TrueloopError, ...]

    def require_plain(self) -> None:
        """Raises SET-FEATURE for the first feature that several set-ups cut."""
        for refusal in self.doubtful:
            raise refusal


def in_setups(profile: Profile, setups: Sequence[Setup], decided: Mapping[str, str | None]) -> InSetups:
    """Finds them. `decided`: by feature the name of the set-up that leaves its surface, where the job says it; None: it
    is to be left alone.

    Raises SET-CUTS for a set-up that cuts nothing of the part, SET-MIRROR for one whose program fits it with Z the
    other way round, NC-NO-TOOL, and NC errors of running.
    """
    found = [_found(profile, setup) for setup in setups]
    for setup, placed, cutters in found:
        _require_direction(profile, setup, placed, cutters)
    cut_in = {name: _decided(decided[name]) if name in decided else _cut_in(name, found) for name in profile.names}
    of_setups = tuple(
        _of_setup(setup, placed, cutters, tuple(name for name in profile.names if cut_in[name] == [setup.frame.name]))
        for setup, placed, cutters in found
    )
    for one in of_setups:
        name = one.setup.frame.name
        if not any(name in where for where in cut_in.values()):
            raise _cuts_nothing(one.setup, f"all that set-up '{name}' cuts is decided to be another's")
    return InSetups(
        of_setups,
        tuple(name for name, where in cut_in.items() if not where),
        tuple(_several(name, where) for name, where in cut_in.items() if len(where) > 1),
    )


_Found = tuple[Setup, Profile, Cutters]


def _found(profile: Profile, setup: Setup) -> _Found:
    placed = setup.frame.profile(profile)
    return setup, placed, cutters_of(setup.program, setup.run, placed, setup.edges, setup.decided)


def _decided(setup: str | None) -> list[str]:
    return [] if setup is None else [setup]


def _cut_in(feature: str, found: Sequence[_Found]) -> list[str]:
    return [setup.frame.name for setup, placed, cutters in found if cutters.cuts(placed.names.index(feature))]


def _of_setup(setup: Setup, placed: Profile, found: Cutters, features: tuple[str, ...]) -> OfSetup:
    """What other set-ups cut, or none, is left alone."""
    own = tuple(one if name in features else None for name, one in zip(placed.names, found.found, strict=True))
    return OfSetup(setup, placed, features, replace(found, found=own))


def _along_mm(profile: Profile, found: Cutters) -> float:
    """How much of the part's profile the program runs along."""
    return sum(found.share(index) * feature.length_mm for index, feature in enumerate(profile.features))


def _require_direction(profile: Profile, setup: Setup, placed: Profile, found: Cutters) -> None:
    """The stated direction of Z is not guessed at, but a program that contradicts it is not corrected."""
    frame, stated_mm = setup.frame, _along_mm(placed, found)
    _, other_way, there = _found(profile, replace(setup, frame=frame.the_other_way))
    other_mm = _along_mm(other_way, there)
    with in_file(setup.program.file):
        if other_mm > MORE * stated_mm:
            raise _mirrored(frame, stated_mm, other_mm)
        if not stated_mm:
            said = f"the program of set-up '{frame.name}' runs along nothing of the part, whichever way its Z points"
            raise _cuts_nothing(setup, f"{said}: {frame.words} is stated")


def _cuts_nothing(setup: Setup, said: str) -> TrueloopError:
    return TrueloopError(
        Code.SET_CUTS,
        said,
        hint="mend its `zero_at_z_mm`, z of the part where this program's Z is 0, or its tools, or leave it out",
        place=Place(setup.program.file),
        values={"setup": setup.frame.name},
    )


def _mirrored(frame: SetupFrame, stated_mm: float, other_mm: float) -> TrueloopError:
    mend = (
        f"leave out `{'flipped' if frame.flipped else 'mirrored_z'}` of the set-up"
        if frame.backwards
        else "state in the set-up `flipped = true` where the part is turned round, `mirrored_z = true` where the "
        "control mirrors Z"
    )
    return TrueloopError(
        Code.SET_MIRROR,
        f"the program of set-up '{frame.name}' runs along {stated_mm:.3f} mm of the part's profile as stated "
        f"({frame.words}), and along {other_mm:.3f} mm with its Z the other way round ({frame.the_other_way.words})",
        hint=f"{mend}; or mend `zero_at_z_mm`",
        values={"setup": frame.name},
    )


def _several(feature: str, setups: Sequence[str]) -> TrueloopError:
    return TrueloopError(
        Code.SET_FEATURE,
        f"'{feature}' is cut in {len(setups)} set-ups: {' and '.join(setups)}",
        hint=f'say which one leaves the surface: [feature.{feature}] setup = "{setups[-1]}"; where each leaves a part '
        "of it, make two features of it",
        values={"feature": feature, "setups": list(setups)},
    )
