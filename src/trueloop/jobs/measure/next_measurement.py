"""From a job to the measurements that are worth taking next, and to the files that take them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from trueloop.controllers.probing import probing_program
from trueloop.controllers.probing.settings import settings_of
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.formats.inspections.gauge_sheet import gauge_sheet_csv
from trueloop.formats.measurements.cmm_plan_csv import cmm_plan_to_csv
from trueloop.formats.option_tables import options_from
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.jobs.measure.probing import by_setup, program_of, reached, read_measuring, read_probing
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.inputs import Measured
from trueloop.jobs.turned.job import ReadCuts, read_cuts
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.next_measurement import (
    Candidate,
    Edge,
    Instrument,
    Plan,
    next_measurements,
    state_of,
)
from trueloop.loops.turned.process_intermittent import process_errors
from trueloop.loops.turned.share import inputs_of_edge, seen_of_edge
from trueloop.nc.program.unit import unit_of_path
from trueloop.probing.cmm_plan import CmmApproach, CmmTouch, cmm_plan
from trueloop.probing.plan import MARGIN_MM, Spacing, equally_spaced
from trueloop.turned.characteristics.measurand import measurand
from trueloop.turned.readings.observed import PLACED_BY_HAND_MM
from trueloop.turned.readings.plan import gauge_plan
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.turned.touches.touches import Gauging, standard_uncertainty_mm

INSTRUMENTS: Final[tuple[Instrument, ...]] = ("probe", "micrometer", "cmm")

MINUTES: Final[Mapping[Instrument, float]] = MappingProxyType({"probe": 0.25, "micrometer": 1.0, "cmm": 0.2})
"""Minutes a measurement takes: a touch on the machine, a size read by hand and noted, a touch of a measuring machine.
Nothing for carrying the part to it. From practice, not from a table: the command line states others."""

CMM_U_MM: Final = 0.001
"""Standard uncertainty of a touch of a measuring machine: an acceptance limit of about 2 µm for a small part."""

POINTS: Final = 7
"""Places on each feature that a ball may touch."""


@dataclass(frozen=True)
class NextOf:
    """A job's plan, and what its measurements are: points for a ball and sizes for a gauge, in the part's frame.

    `measured`: some of the files of touches and readings that the job names are there; else it is planned from the
    priors alone.
    """

    part: str
    profile: Profile
    plan: Plan
    measured: bool
    touches: Mapping[str, CmmTouch]
    sizes: Mapping[str, Characteristic]
    inch: bool
    files: tuple[Path, ...]

    def points(self, instrument: Instrument) -> tuple[CmmTouch, ...]:
        """Returns the points that the plan has for a probe or a measuring machine, in the order of the profile."""
        chosen = {one.name for one in self.plan.chosen if one.instrument == instrument}
        return tuple(touch for name, touch in self.touches.items() if f"{name} ({instrument})" in chosen)

    @property
    def by_hand(self) -> tuple[Characteristic, ...]:
        """Returns the sizes that the plan has for a gauge."""
        chosen = {one.name for one in self.plan.chosen if one.instrument == "micrometer"}
        return tuple(size for name, size in self.sizes.items() if name in chosen)

    def as_dict(self) -> dict[str, object]:
        """Returns the plan for JSON; minutes, and the values before and after in the unit of the criterion."""
        plan = self.plan
        return {
            **{"part": self.part, "criterion": plan.criterion, "before": plan.before, "after": plan.after},
            **{
                "minutes": plan.minutes,
                "enough": plan.enough,
                "measured": self.measured,
                "characteristic": plan.worst or None,
            },
            "measurements": [
                {
                    **{"name": one.name, "feature": one.feature, "instrument": one.instrument},
                    **{"minutes": one.minutes, "before": one.before, "after": one.after},
                }
                for one in plan.chosen
            ],
        }


def next_of_job(
    path: Path,
    count: int,
    instruments: Sequence[Instrument] = INSTRUMENTS,
    minutes: Mapping[Instrument, float] = MINUTES,
) -> NextOf:
    """Plans at most `count` measurements of a job's part, after those that the job names.

    Where none of the files that it names is there, nothing was measured yet. Raises JOB, NC, GEO, TCH, MSR and TOL
    errors.
    """
    files = JobFiles.of(path)
    measured = _was_measured(files)
    cuts = read_cuts(files, None if measured else Measured((), _no_vectors(), (), ()))
    profile, gauging = cuts.read.profile, options_from(Gauging, files.job)
    asked = characteristics_of(files.located, profile)
    places = _places(profile, cuts)
    touches = {touch.name: touch for touch in places}
    planned = gauge_plan(profile, asked) if "micrometer" in instruments else ()
    sizes = {one.name: one for one in planned if one.quantity in (Quantity.DIAMETER, Quantity.LENGTH)}
    probed = _probed(path, files, profile, places) if "probe" in instruments else ()
    by_ball: list[tuple[CmmTouch, Instrument]] = [(one, "probe") for one in probed]
    by_ball += [(one, "cmm") for one in places if "cmm" in instruments]
    seen: list[tuple[str, Instrument, Seen]] = [
        *((touch.feature, kind, _touch(profile, touch, kind, gauging)) for touch, kind in by_ball),
        *((one.feature, "micrometer", _size(profile, one, gauging)) for one in sizes.values()),
    ]
    plan = next_measurements(_edges(cuts, seen, {**MINUTES, **minutes}), count)
    first = files.of_setups[0]
    program = first.finish_program()
    inch = unit_of_path(program.unit, first.run.of(program))["unit"] == "inch"
    return NextOf(files.job.part.name, profile, plan, measured, touches, sizes, inch, (path, *files.sources.files))


def written_files(found: NextOf, source: Path, control: str | None = None) -> dict[str, str]:
    """Returns the texts of the files that take the plan's measurements, by name; of no instrument without any.

    Points of the probe are a list and, for a control, its probing program; those of a measuring machine a list and a
    DMIS program; sizes a sheet to fill in. Raises PRB errors.
    """
    texts = dict[str, str]()
    if probed := found.points("probe"):
        texts["probe.csv"] = cmm_plan_to_csv(probed)
        if control is not None:
            for name, own in by_setup(source, probed).items():
                probing = read_probing(source, own, name or None)
                settings = settings_of(probing.part.name, probing.probe.program, probing.probe.probe)
                file = f"probe-{name}" if name else "probe"
                texts[f"{file}.ngc" if control == "linuxcnc" else f"{file}.nc"] = probing_program(
                    probing.plan, control, settings
                )
    if measured := found.points("cmm"):
        texts["cmm.csv"] = cmm_plan_to_csv(measured)
        measuring = replace(read_measuring(source, (0.0,)), touches=measured, characteristics=())
        approach = CmmApproach(1.0, 3.0, 10.0, measuring.allowance_mm)
        texts["cmm.dms"] = program_of(measuring, approach, source.name)
    if found.by_hand:
        texts["sheet.csv"] = gauge_sheet_csv(found.by_hand, "inch" if found.inch else "mm")
    return texts


def _was_measured(files: JobFiles) -> bool:
    named = [*files.job.gauging.touches_files, *files.job.gauging.readings_files]
    return any((files.path.parent / one).exists() for one in named)


def _no_vectors() -> ErrorVectors:
    none, pairs = np.zeros(0), np.zeros((0, 2))
    return ErrorVectors((), np.zeros(0, np.intp), none, none, none, np.zeros(0, np.bool_), pairs, pairs)


def _places(profile: Profile, cuts: ReadCuts) -> tuple[CmmTouch, ...]:
    """Returns places that a ball may touch on every feature, away from its ends where there is room.

    Of a part that one tool cuts they lie on what its nose reaches.
    """
    edges = [(own, inputs) for setup in cuts.setups for own, inputs in setup.cuts]
    reachable = None
    if len(edges) == 1 and edges[0][0] is None:
        reachable = nose_centre_path(profile, edges[0][1].nose_radius_mm).reachable_mm
    spacings = {}
    for k, feature in enumerate(profile.features):
        length_mm = feature.length_mm if reachable is None else float(reachable[k, 1] - reachable[k, 0])
        if length_mm > 0.0:
            margin_mm = min(MARGIN_MM, 0.2 * length_mm)
            spacings[feature.name] = Spacing(POINTS, margin_mm, margin_mm)
    points = equally_spaced(profile, spacings, reachable)
    names = [f"{profile.names[i]} {k % POINTS + 1}" for k, i in enumerate(points.feature_index.tolist())]
    return cmm_plan(profile, points, names)


def _probed(path: Path, files: JobFiles, profile: Profile, places: Sequence[CmmTouch]) -> tuple[CmmTouch, ...]:
    """Returns the places that the job's probe reaches; all of them where the job names no probe."""
    if files.job.gauging.probe is None:
        return tuple(places)
    setups: list[str | None] = [one.name for one in files.job.setups] or [None]
    found = {touch.name for setup in setups for touch in reached(path, places, setup)}
    return tuple(touch for touch in places if touch.name in found)


def _touch(profile: Profile, touch: CmmTouch, kind: Instrument, gauging: Gauging) -> Seen:
    index = profile.names.index(touch.feature)
    s = float(profile.features[index].locate(touch.place_mm)[0])
    u_mm = float(standard_uncertainty_mm(np.array([touch.normal]), gauging)[0]) if kind == "probe" else CMM_U_MM
    return Seen.at(f"{touch.name} ({kind})", ((index, s, 1.0),), 0.0, u_mm)


def _size(profile: Profile, size: Characteristic, gauging: Gauging) -> Seen:
    """Returns the functional of a diameter or a length; a place held by hand counts where the size changes along it."""
    of = measurand(profile, size, np.zeros(len(profile.features), dtype=np.intp))
    at = zip(of.feature_index.tolist(), of.arc_length_mm.tolist(), strict=True)
    normals = [profile.features[i].outward_normal(s) for i, s in at]
    slope = max(abs(2.0 * n[1] / n[0]) for n in normals) if size.quantity is Quantity.DIAMETER else 0.0
    row = of.gains[0]
    places = tuple(zip(of.feature_index.tolist(), of.arc_length_mm.tolist(), row.tolist(), strict=True))
    return Seen.at(size.name, places, 0.0, float(np.hypot(gauging.readings_u_mm, slope * PLACED_BY_HAND_MM)))


def _edges(
    cuts: ReadCuts, seen: Sequence[tuple[str, Instrument, Seen]], minutes: Mapping[Instrument, float]
) -> list[Edge]:
    kinds = {one.name: (feature, kind) for feature, kind, one in seen}
    edges = []
    for setup in cuts.setups:
        for own, whole in setup.cuts:
            inputs = inputs_of_edge(whole, own)
            measured = len(inputs.touches.point) > 0
            state = state_of(inputs, process_errors(inputs) if measured else inputs.touches)
            mine = seen_of_edge([one for _, _, one in seen], setup.frame, own, cuts.read.profile)
            candidates = tuple(Candidate(one, *kinds[one.name], minutes[kinds[one.name][1]]) for one in mine)
            edges.append(Edge(inputs, state, candidates))
    return edges
