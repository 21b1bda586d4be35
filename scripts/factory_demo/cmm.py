"""The measuring machine: a finished part in, a QIF file in its folder out."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import numpy as np

from scripts.factory_demo.parts import NOSE_MM, PartKind
from scripts.factory_demo.truth import Metal
from trueloop.arrays import Array
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.formats.inspections.qif.writer import qif_of
from trueloop.geometry.offset import nose_centre_path
from trueloop_lab.simulator.mill import VirtualCmm

MACHINE: Final = VirtualCmm(frame_mm=0.0003, tilt_rad=2e-6, mpe_mm=0.0009, mpe_per_mm=0.9e-3 / 350)
POINTS: Final = {"collar": 3, "face": 3, "journal": 4, "shoulder": 2, "neck": 2, "dome": 15, "knob": 15}
DIAMETERS: Final = (("Diameter 1", "collar", 0.020), ("Diameter 2", "journal", 0.015))


def measure(metal: Metal, serial: str, folder: Path, seed: int) -> dict[str, float]:
    """Measures the part that was in the chuck; gives its true errors, RMS and largest of the arc, µm."""
    kind = metal.kind
    feature, at, normal = _places(kind)
    found = MACHINE.measure(metal.stock, at, normal, np.random.default_rng([11, seed]))
    z_mm = _from_face(found, feature, normal)
    points = at + (found - normal[:, 1] * z_mm)[:, None] * normal
    values: tuple[Reading | CmmPoint, ...] = (
        *_diameters(kind, feature, found),
        *(CmmPoint((float(x), 0.0, float(z))) for x, z in points),
    )
    part = Part(PartType(kind.name), serial)
    one = Inspection(
        part,
        "readings and CMM points",
        "",
        len(values),
        values,
        device="CMM 1",
        operator="night shift",
        measured_at=datetime.now(UTC),
    )
    (folder / f".{serial}.qif").write_bytes(qif_of([one]))
    (folder / f".{serial}.qif").rename(folder / f"{serial}.qif")
    return _truth(metal, feature, at, normal)


def _places(kind: PartKind) -> tuple[list[str], Array, Array]:
    """Names of features (n), places and normals (n, 2) on what the nose reaches."""
    names, at, normal = [], [], []
    reachable = nose_centre_path(kind.profile, NOSE_MM).reachable_mm
    for feature, (low, high) in zip(kind.profile.features, reachable, strict=True):
        count = POINTS[feature.name]
        margin = 0.06 * (high - low)
        s = np.linspace(low + margin, high - margin, count)
        names += [feature.name] * count
        at.append(feature.point_mm(s))
        normal.append(feature.outward_normal(s))
    return names, np.concatenate(at), np.concatenate(normal)


def _from_face(error_mm: Array, feature: list[str], normal: Array) -> float:
    """The datum along the axis is the face."""
    face = np.array(feature) == "face"
    return float(np.mean(error_mm[face] / normal[face, 1]))


def _diameters(kind: PartKind, feature: list[str], error_mm: Array) -> list[Reading]:
    readings = []
    for name, of, tolerance in DIAMETERS:
        nominal = 2 * kind.profile.features[kind.profile.names.index(of)].start_mm[0]
        actual = nominal + 2 * float(np.mean(error_mm[np.array(feature) == of]))
        limits = nominal - tolerance, nominal + tolerance
        readings.append(Reading(name, Quantity.DIAMETER, actual, nominal, *limits, feature=of))
    return readings


def _truth(metal: Metal, feature: list[str], at: Array, normal: Array) -> dict[str, float]:
    error = metal.stock.height_mm(at, normal)
    error = error - normal[:, 1] * _from_face(error, feature, normal)
    arc = 1e3 * error[np.array(feature) == metal.kind.profile.names[-1]]
    return {"true_rms_um": float(np.sqrt(np.mean(arc**2))), "true_largest_um": float(np.max(np.abs(arc)))}
