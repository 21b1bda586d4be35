"""From a job, or a part that a store holds, to the measurements worth taking next, and to the files that take them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from trueloop.controllers.probing import probing_program
from trueloop.controllers.probing.settings import settings_of
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.life import Cut, Stage
from trueloop.domain.part import Part
from trueloop.domain.record import Correction as StoredCorrection
from trueloop.domain.tool import Edge as ToolEdge
from trueloop.domain.tool import Setting
from trueloop.errors import Code
from trueloop.formats.input_file import FilePath
from trueloop.formats.inspections.gauge_csv import gauge_sheet_csv, holds_readings
from trueloop.formats.measurements.cmm_plan_csv import cmm_plan_to_csv
from trueloop.formats.measurements.touches_csv import holds_touches
from trueloop.formats.toml_tables import options_from
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.jobs.diagnose.records import part_named
from trueloop.jobs.measure.probing import by_setup, program_of, reached, read_measuring, read_probing
from trueloop.jobs.store.history import REMEMBERED
from trueloop.jobs.store.opened import Choice, store_of
from trueloop.jobs.store.tool_history import history_of_tool
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.compensate import with_memory
from trueloop.jobs.turned.inputs import Measured
from trueloop.jobs.turned.job import ReadCuts, read_cuts
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.shares import stored_inputs
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.deviations import cut_errors
from trueloop.loops.turned.finished_parts import recorded_series
from trueloop.loops.turned.made_parts import is_used, made_part, name_of, today_of
from trueloop.loops.turned.next_measurement import (
    Candidate,
    Edge,
    EdgeState,
    Instrument,
    OfHistory,
    OfPart,
    OfSeries,
    Plan,
    next_measurements,
)
from trueloop.loops.turned.process_intermittent import process_errors, series_known
from trueloop.loops.turned.share import characteristics_in, frame_of, inputs_of_edge, seen_of_edge
from trueloop.memory.edge.predict import remembered
from trueloop.memory.made_part import MadePart
from trueloop.nc.program.unit import unit_of_path
from trueloop.probing.cmm_plan import CmmApproach, CmmTouch, cmm_plan
from trueloop.probing.probe_plan import MARGIN_MM, Spacing, equally_spaced
from trueloop.storage.store import Store, find
from trueloop.turned.characteristics.measurand import measurand
from trueloop.turned.fit.prior.part_state import part_state
from trueloop.turned.readings.observed import PLACED_BY_HAND_MM
from trueloop.turned.readings.sizes import gauge_plan
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.turned.touches.touches import Gauging, standard_uncertainty_mm

INSTRUMENTS: Final[tuple[Instrument, ...]] = ("probe", "micrometer", "cmm")

BALLS: Final[tuple[Instrument, ...]] = ("probe", "cmm")

MINUTES: Final[Mapping[Instrument, float]] = MappingProxyType({"probe": 0.25, "micrometer": 1.0, "cmm": 0.2})
"""Minutes a measurement takes: a touch on the machine, a size read by hand and noted, a touch of a measuring machine.
Nothing for carrying the part to it. From practice, not from a table: the command line states others."""

CMM_U_MM: Final = 0.001
"""Standard uncertainty of a touch of a measuring machine: an acceptance limit of about 2 µm for a small part."""

SHEET: Final = "sheet.csv"
"""The file of sizes to fill in."""

POINTS: Final = 7
"""Places on each feature that a ball may touch."""


@dataclass(frozen=True)
class NextOf:
    """A plan, and what its measurements are: points for a ball and sizes for a gauge, in the part's frame.

    `measured`: some of the files of touches and readings that the job names have values; else it is planned from the
    priors alone.
    """

    part: str
    plan: Plan
    measured: bool
    touches: Mapping[str, CmmTouch]
    sizes: Mapping[str, Characteristic]
    inch: bool
    files: tuple[Path, ...]

    def points(self, instrument: Instrument) -> tuple[CmmTouch, ...]:
        """Returns the points that the plan has for a probe or a measuring machine, in the order of the profile."""
        chosen = {measurement.name for measurement in self.plan.chosen if measurement.instrument == instrument}
        return tuple(touch for name, touch in self.touches.items() if f"{name} ({instrument})" in chosen)

    @property
    def by_hand(self) -> tuple[Characteristic, ...]:
        """Returns the sizes that the plan has for a gauge."""
        chosen = {measurement.name for measurement in self.plan.chosen if measurement.instrument == "micrometer"}
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
                    **{"name": measurement.name, "feature": measurement.feature, "instrument": measurement.instrument},
                    **{"minutes": measurement.minutes, "before": measurement.before, "after": measurement.after},
                }
                for measurement in plan.chosen
            ],
        }


def plan_measurements(
    path: FilePath,
    count: int = 5,
    instruments: Sequence[Instrument] = INSTRUMENTS,
    minutes: Mapping[Instrument, float] = MINUTES,
    db: Choice = None,
) -> NextOf:
    """Plans at most `count` measurements of a job's part, after those that the job names, and by what earlier parts of
    its edges have shown, where a store knows them: `db`, or that of the job.

    Where none of the files that it names is there, nothing was measured yet. Raises JOB, NC, GEO, TCH, MSR, TOL, STO
    and EDG errors.

    >>> planned = trueloop.plan_measurements(trueloop.example("shaft/job.toml"), 2)
    >>> [measurement.name for measurement in planned.plan.chosen]
    ['end-face 4 (cmm)', 'cone 4 (cmm)']
    """
    path = Path(path)
    files = JobFiles.of(path)
    gauging, folder = files.job.gauging, files.path.parent
    measured = any(holds_touches(folder / one) for one in gauging.touches_files)
    measured = measured or any(holds_readings(folder / one) for one in gauging.readings_files)
    cuts = read_cuts(files, None if measured else Measured((), _no_vectors(), (), ()))
    profile = cuts.read.profile
    asked = characteristics_of(files.located, profile)
    places = _places(profile, _nose_mm(cuts))
    touches = {touch.name: touch for touch in places}
    sizes = _sizes(profile, asked, instruments)
    probed = _probed(path, files, profile, places) if "probe" in instruments else ()
    by_ball: list[tuple[CmmTouch, Instrument]] = [(cmm_touch, "probe") for cmm_touch in probed]
    by_ball += [(place, "cmm") for place in places if "cmm" in instruments]
    seen = _seen(profile, by_ball, sizes, options_from(Gauging, files.job))
    store = store_of(path.parent, db, files.job.store.db)
    plan = next_measurements(_edges(cuts, seen, {**MINUTES, **minutes}, store), count)
    first = files.of_setups[0]
    program = first.finish_program()
    inch = unit_of_path(program.unit, first.run.of(program))["unit"] == "inch"
    return NextOf(
        part=files.job.part.name,
        plan=plan,
        measured=measured,
        touches=touches,
        sizes=sizes,
        inch=inch,
        files=(path, *files.sources.files),
    )


def written_files(plan: NextOf, source: Path | None, control: str | None = None) -> dict[str, str]:
    """Returns the texts of the files that take the plan's measurements, by name; of no instrument without any.

    Points of the probe are a list and, for a control, its probing program; those of a measuring machine a list and a
    DMIS program; sizes a sheet to fill in. Programs are made by a job's probe and allowance: None, of a part without
    its job, has lists and a sheet. Raises PRB errors.
    """
    texts = dict[str, str]()
    if probed := plan.points("probe"):
        texts["probe.csv"] = cmm_plan_to_csv(probed)
        if control is not None and source is not None:
            for name, own in by_setup(source, probed).items():
                probing = read_probing(source, own, name or None)
                settings = settings_of(probing.part.name, probing.probe.program, probing.probe.probe)
                file = f"probe-{name}" if name else "probe"
                texts[f"{file}.ngc" if control == "linuxcnc" else f"{file}.nc"] = probing_program(
                    probing.plan, control, settings
                )
    if measured := plan.points("cmm"):
        texts["cmm.csv"] = cmm_plan_to_csv(measured)
    if measured and source is not None:
        measuring = replace(read_measuring(source, (0.0,)), touches=measured, characteristics=())
        approach = CmmApproach(1.0, 3.0, 10.0, measuring.allowance_mm)
        texts["cmm.dms"] = program_of(measuring, approach, source.name)
    if plan.by_hand:
        texts[SHEET] = gauge_sheet_csv(plan.by_hand, "inch" if plan.inch else "mm")
    return texts


def _no_vectors() -> ErrorVectors:
    none, pairs = np.zeros(0), np.zeros((0, 2))
    return ErrorVectors(
        point=(),
        feature_index=np.zeros(0, np.intp),
        arc_length_mm=none,
        error_mm=none,
        standard_u_mm=none,
        at_reference=np.zeros(0, np.bool_),
        nominal_mm=pairs,
        outward_normal=pairs,
    )


def _places(profile: Profile, nose_radius_mm: float | None) -> tuple[CmmTouch, ...]:
    """Returns places that a ball may touch on each feature, off its ends, within reach of the nose of the one tool."""
    reachable = None if nose_radius_mm is None else nose_centre_path(profile, nose_radius_mm).reachable_mm
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
    setups: list[str | None] = [table.name for table in files.job.setups] or [None]
    found = {touch.name for setup in setups for touch in reached(path, places, setup)}
    return tuple(touch for touch in places if touch.name in found)


def _seen(
    profile: Profile,
    by_ball: Sequence[tuple[CmmTouch, Instrument]],
    sizes: Mapping[str, Characteristic],
    gauging: Gauging,
) -> list[tuple[str, Instrument, Seen]]:
    """Returns all measurements that can be taken, each with its feature and instrument."""
    return [
        *((touch.feature, kind, _touch(profile, touch, kind, gauging)) for touch, kind in by_ball),
        *((size.feature, "micrometer", _size(profile, size, gauging)) for size in sizes.values()),
    ]


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


def _nose_mm(cuts: ReadCuts) -> float | None:
    edges = [(own, inputs) for setup in cuts.setups for own, inputs in setup.cuts]
    return edges[0][1].nose_radius_mm if len(edges) == 1 and edges[0][0] is None else None


def _edges(
    cuts: ReadCuts,
    readings: Sequence[tuple[str, Instrument, Seen]],
    minutes: Mapping[Instrument, float],
    store: Store | None = None,
) -> list[Edge]:
    edges = []
    for setup in cuts.setups:
        for own, whole in setup.cuts:
            inputs = inputs_of_edge(whole, own)
            if store is not None:
                inputs = with_memory(store, stored_inputs(inputs, cuts.read.profile, own), None)
            errors = process_errors(inputs) if len(inputs.touches.point) else inputs.touches
            mine = seen_of_edge([observation for _, _, observation in readings], setup.frame, own, cuts.read.profile)
            edges.append(
                Edge(
                    profile=inputs.profile,
                    vectors=errors,
                    characteristics=inputs.characteristics,
                    zero_z_mm=inputs.part_zero_z_mm,
                    known=_known(inputs, errors),
                    candidates=_candidates(mine, readings, minutes),
                )
            )
    return edges


def _known(inputs: Inputs, errors: ErrorVectors) -> EdgeState:
    """Returns what the measured errors of an edge's part show, with the earlier parts that take part."""
    finished = inputs.measured_finished and len(errors.point) > 0
    if finished and (series := series_known(inputs)) is not None:
        return OfSeries(series)
    if inputs.measured_finished or not is_used(inputs):
        return OfPart(part_state(inputs.profile, errors), inputs.options.between_cuts)
    today = today_of(inputs, cut_errors(inputs.profile, errors))
    return OfHistory.of(inputs.profile, errors, remembered(inputs.history, inputs.memory), today)


def _known_of_stored(store: Store, correction: Correction) -> EdgeState:
    """Returns what is known after the part of a stored correction, with the earlier parts that take part."""
    profile, vectors = correction.profile, correction.model.vectors
    if correction.record.cut_with is not None and (series := recorded_series(correction)) is not None:
        return OfSeries(series)
    if correction.record.cut_with is not None or correction.record.edge is None:
        return OfPart(part_state(profile, vectors), correction.options.between_cuts)
    return OfHistory.of(profile, vectors, *_parts_of(store, correction, correction.record.edge))


def _candidates(
    mine: Sequence[Seen], readings: Sequence[tuple[str, Instrument, Seen]], minutes: Mapping[Instrument, float]
) -> tuple[Candidate, ...]:
    kinds = {observation.name: (feature, kind) for feature, kind, observation in readings}
    return tuple(
        Candidate(observation, *kinds[observation.name], minutes[kinds[observation.name][1]]) for observation in mine
    )


def next_of_part(
    store: Store,
    serial: str,
    count: int,
    instruments: Sequence[Instrument] = INSTRUMENTS,
    minutes: Mapping[Instrument, float] = MINUTES,
    part_type: str | None = None,
) -> NextOf:
    """Plans at most `count` measurements of a part that a store holds, after those that it holds of this part and of
    earlier parts of its edges.

    The profile, the tools and the limits are those of the part's corrections. Raises DIA-NONE for a part that is not in
    the store, or without a correction; STO and MEM errors.
    """
    whole = part_named(store, serial, part_type)
    made = [one for share in whole.shares if (one := _correction_of(store, share)) is not None]
    if not made:
        raise Code.DIA_NONE.refusal(
            f"part {serial!r} has no correction in the store, by which its profile would be known",
            hint="name its job instead of its serial number",
        )
    touches, sizes, edges = dict[str, CmmTouch](), dict[str, Characteristic](), list[Edge]()
    for correction in made:
        profile, frame, gauging = correction.profile, frame_of(correction), _gauging(correction)
        asked = characteristics_in(
            frame, [characteristic.characteristic for characteristic in correction.characteristics]
        )
        places = _places(profile, correction.nose_radius_mm)
        own = _sizes(profile, asked, instruments)
        seen = _seen(
            profile, [(place, kind) for kind in BALLS if kind in instruments for place in places], own, gauging
        )
        candidates = _candidates([observation for _, _, observation in seen], seen, {**MINUTES, **minutes})
        edges.append(
            Edge(
                profile=profile,
                vectors=correction.model.vectors,
                characteristics=asked,
                zero_z_mm=frame.z_mm(0.0),
                known=_known_of_stored(store, correction),
                candidates=candidates,
            )
        )
        touches |= {place.name: _on_part(place, frame) for place in places}
        sizes |= {
            characteristic.name: characteristic
            for characteristic in characteristics_in(frame.back, tuple(own.values()))
        }
    program = made[0].record.program
    plan, inch = next_measurements(edges, count), program is not None and program.unit == "inch"
    return NextOf(
        part=whole.part.part_type.name, plan=plan, measured=True, touches=touches, sizes=sizes, inch=inch, files=()
    )


def _correction_of(store: Store, part: Part) -> Correction | None:
    """Returns the last correction that was made from measurements of a part."""
    found = find(store, StoredCorrection, part_type=part.part_type.name, serial=part.serial, product=REMEMBERED)
    made = [stored.value.payload for stored in found if isinstance(stored.value.payload, Correction)]
    of_part = (
        correction
        for correction in made
        if any(of.part.identity == part.identity for of in correction.record.inspections)
    )
    return next(iter(reversed([*of_part])), None)


def _parts_of(store: Store, correction: Correction, edge: ToolEdge) -> tuple[tuple[MadePart, ...], MadePart]:
    """Returns earlier parts of a correction's edge and the part that it was made from, as memory works on them.

    Of the edge those whose program was corrected for known errors of the machine as this one was, or was not.
    """
    record, of_machine = correction.record, correction.composed is not None
    part = record.inspections[0].part
    own = (name_of(part.part_type), part.serial)
    parts = history_of_tool(store, edge, (), of_machine, own)
    for k, one in enumerate(parts):
        if one.order >= 0 and (one.part_type, one.serial) == own:
            return parts[:k], one
    order = 1 + max((int(one.order) for one in parts if one.order >= 0), default=-1)
    cut = Cut(part, Stage.SEMIFINISH, Setting(edge, record.edge_set_at), order=order)
    return parts, made_part(correction, cut, None)


def _on_part(touch: CmmTouch, frame: SetupFrame) -> CmmTouch:
    x, z = frame.back.directions(touch.normal).tolist()
    return replace(touch, place_mm=frame.back.point(touch.place_mm), normal=(x, z))


def _gauging(correction: Correction) -> Gauging:
    """Returns the repeatability of the touches that a correction was made from; of readings, what holds unstated."""
    vectors = correction.model.vectors
    own = vectors.own_u_mm[vectors.by_probe & ~vectors.at_reference]
    if not len(own):
        return Gauging()
    range_mm = float(np.median(own)) * math.sqrt(12.0)
    return Gauging(range_x_mm=range_mm, range_z_mm=range_mm)


def _sizes(
    profile: Profile, characteristics: Sequence[Characteristic], instruments: Sequence[Instrument]
) -> dict[str, Characteristic]:
    planned = gauge_plan(profile, characteristics) if "micrometer" in instruments else ()
    return {
        characteristic.name: characteristic
        for characteristic in planned
        if characteristic.quantity in (Quantity.DIAMETER, Quantity.LENGTH)
    }
