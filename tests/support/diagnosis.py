"""Diagnoses for pages: a series with a tool offset, a fixturing with a step, a machine with a set of errors."""

from typing import Literal

import numpy as np

from trueloop.diagnosis.causes.cause import Candidate, Cause, Diagnosis, Over, SeenBy, SeenPart, SeenSeries, Sign
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError, FeaturePlace
from trueloop.report.diagnosis.machine_shapes import (
    ChangeShape,
    CorrelationShape,
    LeftOutShape,
    MachineDiagnosisShape,
    RefinementShape,
    ResidualShape,
    SuspectShape,
    TermSetShape,
)
from trueloop.report.diagnosis.shapes import FixtureDiagnosisShape, FixturingShape, JudgedShape, PointShape
from trueloop.wording import Um, wording

OF: tuple[Literal["parts"], Literal["part types"]] = ("parts", "part types")
OFFSET = Cause(
    "tool-offset",
    "tool offset",
    (Sign(ErrorKind.RADIUS, (SeenBy.MACHINE, SeenBy.CMM), (Over.SETTING,), True),),
    0.1,
    "change tool offset by w · Δr",
    "[4773 §4.2 a]",
    "next part after a new setting",
)
PROBE = Cause(
    "probe-offset",
    "part-probe offset",
    (Sign(ErrorKind.RADIUS, (SeenBy.CMM,), (Over.CONSTANT,), True),),
    0.05,
    "calibrate probe on a standard part",
    "[4773 §4.2 a]",
    "a standard part under standard conditions",
    True,
)


def seen_series(parts: int = 12, features: int = 3, long_names: bool = False) -> SeenSeries:
    """A tool offset of 12 µm on the machine's probe and the CMM, 2 µm between them; the tool is set at the sixth."""
    rng = np.random.default_rng(4)
    names = [
        f"journal <{k}> of a very long intermediate shaft" if long_names else f"journal {k}" for k in range(features)
    ]
    made = []
    for k in range(parts):
        level = 0.012 if k < 6 else 0.001
        radii = {name: level + 0.001 * rng.standard_normal() for name in names}
        errors = {
            SeenBy.MACHINE: tuple(_error(name, ErrorKind.RADIUS, value) for name, value in radii.items()),
            SeenBy.CMM: (
                *(_error(name, ErrorKind.RADIUS, value + 0.002) for name, value in radii.items()),
                FeatureError("end", ErrorKind.LENGTH, -0.004, 0.0008, 6, other="shoulder"),
            ),
        }
        serial = f"SN-2026-11-{k:04d}-LINE-A" if long_names else f"P{k}"
        made.append(
            SeenPart(serial, k, errors, setting={"T01": 1 + (k >= 6)}, temperatures={"spindle": 21.0 + 0.1 * k})
        )
    places = {name: FeaturePlace(name, "shaft", (20.0, 20.0), (0.0, 40.0), "T01") for name in names}
    return SeenSeries(places, tuple(made))


def _error(name: str, kind: ErrorKind, value_mm: float) -> FeatureError:
    return FeatureError(name, kind, value_mm, 0.0007, 4)


def guilty(features: tuple[str, ...] = ("journal 0", "journal 1", "journal 2")) -> Diagnosis:
    """A tool offset, and what is left besides."""
    supports = (wording("{x} (on the radius)", x=Um(0.012, "+.1f")),)
    candidates = (
        Candidate(OFFSET, features, 0.962, 0.0118, 0.0006, supports, ("one of three features moves less",)),
        Candidate(PROBE, features, 0.041, 0.002, 0.0005),
    )
    hypotheses = (
        (("tool-offset",), 0.955),
        (("probe-offset",), 0.034),
        (("tool-offset", "probe-offset"), 0.007),
        ((), 0.004),
    )
    return Diagnosis(candidates, hypotheses, 0.004, ("a standard part under standard conditions",))


def torn() -> Diagnosis:
    """Two causes that the data do not tell apart."""
    first, second = guilty().candidates
    hypotheses = ((("tool-offset",), 0.5), (("probe-offset",), 0.47), ((), 0.03))
    return Diagnosis((first, second), hypotheses, 0.03)


def sound_series(parts: int = 12) -> SeenSeries:
    """Errors about as large as their uncertainty."""
    rng = np.random.default_rng(11)
    made = [
        SeenPart(f"P{k}", k, {SeenBy.MACHINE: (_error("journal 0", ErrorKind.RADIUS, 0.0007 * rng.standard_normal()),)})
        for k in range(parts)
    ]
    return SeenSeries({"journal 0": FeaturePlace("journal 0", "shaft", (20.0, 20.0), (0.0, 40.0), "T01")}, tuple(made))


def sound() -> Diagnosis:
    """Nothing acts."""
    return Diagnosis((), (((), 0.981), (("tool-offset",), 0.019)), 0.981)


def point(name: str = "journal 1, point 3") -> PointShape:
    """A point at which machine and process were compensated in part: ERROR_PP = 3 + 4 µm."""
    return PointShape(
        name=name, error_pp_um=7.0, error_mtg_um=13.0, error_mtg_resid_um=3.0, error_proc_um=-11.0,
        error_proc_resid_um=4.0, comp_mtg_um=-10.0, comp_proc_um=15.0, u_error_pp_um=0.5, u_error_mtg_um=0.8,
        u_error_proc_um=0.6,
    )  # fmt: skip


def fixtures() -> FixtureDiagnosisShape:
    """A part that moved once, and a tool probe that is stable."""
    moved = [-4.1, -3.6, -4.4, -3.9, 4.2, 3.8, 4.0, 4.0]
    still = [0.3, -0.2, 0.1, -0.4, 0.2, 0.0]
    none = JudgedShape(value_um=0.1, standard_u_um=0.3, significant=False)
    step = JudgedShape(value_um=8.0, standard_u_um=0.3, significant=True)
    part, probe = (
        FixturingShape(
            name=name, values_um=values, standard_u_um=0.4, limit_um=2.0, spread=none, drift=none, step=jump,
            step_after=after, stable=after is None,
        )
        for name, values, jump, after in (("part", moved, step, 4), ("tool probe", still, none, None))
    )  # fmt: skip
    return FixtureDiagnosisShape(
        machine="lathe <1>",
        fixturings=[part, probe],
        findings=[],
    )  # fmt: skip


def machine(parts: int = 20, points: int = 12) -> MachineDiagnosisShape:
    """A model that has a growth with temperature wrong, which one tool cannot tell from a tilt."""
    rng = np.random.default_rng(7)
    residuals, carriage = [], []
    for k in range(parts):
        warm = 20.0 + 10.0 * rng.random()
        for n in range(points):
            z = 10.0 * n
            value = 0.05 * z * (warm - 25.0) / 5.0 + 30.0 * (k % 3) + rng.standard_normal()
            residuals.append(ResidualShape(part=f"P<{k}>", position_mm={"X": 20.0, "Z": z}, residual_um=value))
            carriage.append(warm)
    own = CorrelationShape(error="EXZ", signal="T_carriage", correlation=0.81)
    return MachineDiagnosisShape(
        machine="lathe <1>", model="2026-11 (3f2a9c)", parts=parts, points=len(residuals), sound=0.004, scatter_um=1.1,
        sets=[found_set()], by_error={"EXZ": 0.52, "EBZ": 0.45, "EXX": 0.02}, residuals=residuals,
        temperatures={"T_carriage": carriage}, frames=None, own_way=[own], refinement=refined(), findings=[],
    )  # fmt: skip


def found_set(*names: str) -> TermSetShape:
    """Errors that one tool does not tell apart."""
    errors = [SuspectShape(error=e, follows="T_carriage", probability=0.5) for e in names or ("EXZ", "EBZ")]
    by = ["a tool of another length in X"] if len(errors) > 1 else []
    return TermSetShape(errors=errors, probability=0.973, at_least=1, separated_by=by)


def refined() -> RefinementShape:
    """Offered."""
    left = [
        LeftOutShape(of=of, groups=4, points=240, before_um=4.0, after_um=1.9, better_um=2.1, standard_u_um=0.3)
        for of in OF
    ]
    change = ChangeShape(
        error="EXZ", unit="µm", at=100.0, signals={"T_carriage": 29.0}, old=1.0, new=5.2, standard_u=0.8
    )
    return RefinementShape(
        version=1, parent="3f2a9c" * 10, reason="EXZ and EBZ", errors=["EXZ", "EBZ"], parts=20, left_out=left,
        better=True, changes=[change], accepted=None,
    )  # fmt: skip
