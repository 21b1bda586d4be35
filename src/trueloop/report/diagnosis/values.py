"""Diagnoses of parts and series as values for JSON and for the pages."""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from statistics import fmean, stdev
from typing import Final

from trueloop.diagnosis.causes.cause import Diagnosis, SeenBy, SeenPart, SeenSeries
from trueloop.diagnosis.components import Components, FrameDiscrepancy
from trueloop.diagnosis.features.feature_error import DECIMALS, FeatureError
from trueloop.errors import Finding
from trueloop.report.diagnosis.shapes import (
    CandidateShape,
    CausesShape,
    FeatureErrorShape,
    FeatureMeansShape,
    FrameShape,
    HypothesisShape,
    MeanShape,
    PartDiagnosisShape,
    PointMeansShape,
    PointShape,
    SeenPartShape,
    SeriesDiagnosisShape,
    UnexplainedShape,
)
from trueloop.report.series.values import findings_shape
from trueloop.report.shape import known_um, um
from trueloop.units import URAD_PER_RAD

PROBABLE: Final = 0.5
"""Causes that together have less probability explain nothing."""
MEAN: Final = 4.0
"""Standard uncertainties from which a mean is said to be there: one of some hundred errors of sound parts at most."""
SCATTER: Final = 5.0
"""Standard uncertainties of one part from which parts differ: cuts repeat less well than a probe does."""


def unexplained(means: Sequence[FeatureMeansShape], causes: CausesShape) -> list[UnexplainedShape]:
    """Errors beyond their uncertainty on features on which probably nothing acts, furthest first."""
    free = [shape for shape in means if acting(shape.feature, causes) < PROBABLE]
    found = [each for shape in free for each in _of(shape)]
    return sorted(found, key=lambda each: -abs(each.size_um) / max(each.standard_u_um, 1e-6))


def acting(feature: str, causes: CausesShape) -> float:
    """Returns the probability that one cause or another acts on a feature; a cause without features acts on all."""
    on = {candidate.key for candidate in causes.candidates if feature in candidate.features or not candidate.features}
    return sum(hypothesis.probability for hypothesis in causes.hypotheses if on & set(hypothesis.causes))


def _of(means: FeatureMeansShape) -> Iterator[UnexplainedShape]:
    """Of one error at most one for each device: its mean, else its scatter."""
    for device, mean in (("machine", means.machine), ("CMM", means.cmm)):
        if mean is not None and (shown := _beyond(means, device, mean)) is not None:
            yield shown


def _beyond(means: FeatureMeansShape, device: str, mean: MeanShape) -> UnexplainedShape | None:
    known = {"feature": means.feature, "other": means.other, "kind": means.kind, "device": device}
    if mean.standard_u_um is not None and abs(mean.mean_um) > MEAN * mean.standard_u_um > 0.0:
        return UnexplainedShape(**known, shows="mean", size_um=mean.mean_um, standard_u_um=mean.standard_u_um)
    scatter, u = mean.scatter_um, mean.one_part_u_um
    if scatter is not None and u is not None and scatter > SCATTER * u > 0.0:
        return UnexplainedShape(**known, shows="scatter", size_um=scatter, standard_u_um=u)
    return None


Key = tuple[str, str, str]
"""Feature, the nearer face of a length, kind."""


def part_shape(
    part_type: str,
    part: SeenPart,
    diagnosis: Diagnosis | None = None,
    findings: Sequence[Finding] = (),
    *,
    points: Sequence[str] = (),
    components: Components | None = None,
    frame: FrameDiscrepancy | None = None,
) -> PartDiagnosisShape:
    """Makes the shape of one part; `points` are the names of the points of `components`."""
    return PartDiagnosisShape(
        part_type=part_type,
        part=seen_part(part, None),
        causes=None if diagnosis is None else causes_shape(diagnosis),
        frame=None if frame is None else frame_shape(frame),
        points=[] if components is None else [point_shape(name, components, k) for k, name in enumerate(points)],
        findings=findings_shape(findings),
    )


def series_shape(
    part_type: str, series: SeenSeries, diagnosis: Diagnosis | None, findings: Sequence[Finding] = ()
) -> SeriesDiagnosisShape:
    """Parts of one type; no diagnosis where nothing is concluded."""
    before = (None, *series.parts)
    means, causes = means_of(series.parts), None if diagnosis is None else causes_shape(diagnosis)
    return SeriesDiagnosisShape(
        part_type=part_type,
        causes=causes,
        means=means,
        points=points_of(series.parts),
        unexplained=[] if causes is None else unexplained(means, causes),
        parts=[seen_part(part, last) for part, last in zip(series.parts, before, strict=False)],
        findings=findings_shape(findings),
    )


def seen_part(part: SeenPart, last: SeenPart | None) -> SeenPartShape:
    """Makes the shape of a part after the last one: a tool was set where its count of settings rose."""
    was = part.setting if last is None else last.setting
    return SeenPartShape.from_values(
        part,
        at=None if part.at is None else part.at.isoformat(),
        tool_set=[tool for tool, count in part.setting.items() if count > was.get(tool, count)],
        errors={device.value: [_feature_error(error) for error in errors] for device, errors in part.errors.items()},
    )


def _feature_error(error: FeatureError) -> FeatureErrorShape:
    more = {name: value for name, value in error.more.items() if math.isfinite(value)}
    return FeatureErrorShape.from_values(error, more=more)


def means_of(parts: Sequence[SeenPart]) -> list[FeatureMeansShape]:
    """Returns each error over the parts that were cut, in the order in which the parts name them."""
    seen: dict[Key, dict[str, list[tuple[float, float]]]] = defaultdict(lambda: defaultdict(list))
    for part in parts:
        if not part.standard:
            for key, of_it in _by_key(part).items():
                for device, error in of_it.items():
                    seen[key][device.value].append((error.value_mm, error.standard_u_mm))
                if len(of_it) == len(SeenBy):
                    cmm, machine = of_it[SeenBy.CMM], of_it[SeenBy.MACHINE]
                    u = math.hypot(cmm.standard_u_mm, machine.standard_u_mm)
                    seen[key]["difference"].append((cmm.value_mm - machine.value_mm, u))
    return [_means(key, of_it) for key, of_it in seen.items()]


def _means(key: Key, of_it: Mapping[str, Sequence[tuple[float, float]]]) -> FeatureMeansShape:
    feature, other, kind = key
    machine, cmm, difference = (_mean(of_it.get(name, ())) for name in ("machine", "CMM", "difference"))
    return FeatureMeansShape(
        feature=feature, other=other, kind=kind, machine=machine, cmm=cmm, difference=difference
    )  # fmt: skip


def _by_key(part: SeenPart) -> dict[Key, dict[SeenBy, FeatureError]]:
    found: dict[Key, dict[SeenBy, FeatureError]] = {}
    for device, errors in part.errors.items():
        for error in errors:
            if math.isfinite(error.value_mm):
                found.setdefault((error.feature, error.other, error.kind.value), {})[device] = error
    return found


def points_of(parts: Sequence[SeenPart]) -> list[PointMeansShape]:
    """Returns each gauging point over the cut parts, in their order; repeats on one part count as their mean."""
    seen: dict[tuple[str, float, float], dict[SeenBy, dict[str, list[tuple[float, float]]]]] = {}
    for part in parts:
        for device, points in {} if part.standard else part.points.items():
            rows = zip(points.feature, points.nominal_mm.tolist(), points.error_mm, points.standard_u_mm, strict=True)
            for feature, (x, z), error, u in rows:
                place = seen.setdefault((feature, round(x, DECIMALS), round(z, DECIMALS)), {})
                place.setdefault(device, {}).setdefault(part.serial, []).append((float(error), float(u)))
    return [_point(*place, of_it) for place, of_it in seen.items()]


def _point(
    feature: str, x_mm: float, z_mm: float, of_it: Mapping[SeenBy, Mapping[str, Sequence[tuple[float, float]]]]
) -> PointMeansShape:
    machine, cmm = (
        {
            serial: (fmean(error for error, _ in values), math.sqrt(sum(u**2 for _, u in values)) / len(values))
            for serial, values in of_it.get(device, {}).items()
        }
        for device in (SeenBy.MACHINE, SeenBy.CMM)
    )
    return PointMeansShape(
        feature=feature,
        x_mm=x_mm,
        z_mm=z_mm,
        machine=_mean([*machine.values()]),
        cmm=_mean([*cmm.values()]),
        machine_um={serial: um(error) for serial, (error, _) in machine.items()},
        cmm_um={serial: um(error) for serial, (error, _) in cmm.items()},
    )


def _mean(means: Sequence[tuple[float, float]]) -> MeanShape | None:
    """Of values with their standard uncertainties: no less than the parts scatter by, over the root of their number."""
    if not means:
        return None
    values = [value for value, _ in means]
    scatter = stdev(values) if len(values) > 1 else None
    one_part = math.sqrt(fmean(u**2 for _, u in means))
    u = max(one_part, scatter or 0.0) / math.sqrt(len(values))
    return MeanShape(
        parts=len(values),
        mean_um=um(fmean(values)),
        standard_u_um=known_um(u),
        scatter_um=known_um(scatter),
        one_part_u_um=known_um(one_part),
    )


def causes_shape(diagnosis: Diagnosis) -> CausesShape:
    """Returns the shape of the causes that act."""
    return CausesShape.from_values(
        diagnosis,
        candidates=[CandidateShape.from_values(candidate, candidate.cause) for candidate in diagnosis.candidates],
        hypotheses=[HypothesisShape(causes=list(keys), probability=share) for keys, share in diagnosis.hypotheses],
    )


def point_shape(name: str, parts: Components, k: int) -> PointShape:
    """Makes the shape of the k-th gauging point."""
    shown = {"comp_mtg": parts.comp_mtg_applied} | vars(parts)
    fields = [field for field in PointShape.model_fields if field != "name"]
    return PointShape(name=name, **{field: um(float(shown[field.removesuffix("_um")][k])) for field in fields})


def frame_shape(frame: FrameDiscrepancy) -> FrameShape:
    """Makes the shape of what the frames of CMM and machine differ by."""
    turn_urad = [round(float(one) * URAD_PER_RAD, 4) + 0.0 for one in frame.turn_rad]
    return FrameShape.from_values(frame, shift_um=[um(float(one)) for one in frame.shift_mm], turn_urad=turn_urad)
