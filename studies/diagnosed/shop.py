"""A series of parts in the simulated shop: cut, inspected on the machine, measured by a CMM, corrected as recorded."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from studies.diagnosed.axis_errors import REFERENCE_C, SIGNALS, TOOLS_MM, left_mm
from studies.diagnosed.day import Moment, day
from studies.diagnosed.part_types import SLIM, Gauged, PartType, gauged, places
from studies.diagnosed.process_errors import DEEPER, USUAL_DEPTH_MM, Cut, process_errors
from studies.diagnosed.truth import Fault, Truth
from trueloop.arrays import Array
from trueloop.diagnosis.causes.cause import SeenBy
from trueloop.diagnosis.features.feature_error import FeaturePlace


@dataclass(frozen=True)
class Shop:
    """How it works. Noise is a standard deviation in mm: of cuts from part to part, of one touch by each device.

    `set_anew` are the orders of parts before which every tool got a new edge and was set. `corrected_from` is the first
    part cut with a correction, by what the machine saw on those before it. `standard_at` are the orders before which a
    calibrated part was probed. `cooled_k` is by how much the machine cools between cutting and probing.
    """

    part: PartType = SLIM
    tools: tuple[str, ...] = ("T1",)
    parts: int = 12
    set_anew: tuple[int, ...] = (6,)
    corrected_from: int | None = None
    standard_at: tuple[int, ...] = ()
    cut_mm: float = 0.0010
    probe_mm: float = 0.0008
    cmm_mm: float = 0.0005
    stock: float = 0.2
    cooled_k: float = 0.3
    steady: bool = False
    minutes_in_cut: float = 6.0


@dataclass(frozen=True)
class Made:
    """One part: how it was cut, its moment, what each device read at the points, what corrections took off points."""

    cut: Cut
    moment: Moment
    read_mm: Mapping[SeenBy, Array]
    corrected_mm: Mapping[str, float] = field(default_factory=dict)
    standard: bool = False


@dataclass(frozen=True)
class Series:
    """What was wrong, the shop, its features and gauging points, and the parts in order."""

    truth: Truth
    shop: Shop
    places: Mapping[str, FeaturePlace]
    points: Gauged
    made: tuple[Made, ...]


def cut_series(truth: Truth, shop: Shop = Shop(), seed: int = 0) -> Series:
    """The whole series; all that is random comes from `seed`."""
    rng = np.random.default_rng(seed)
    features = places(shop.part, shop.tools)
    points = gauged(features)
    moments = day(shop.parts, rng, shop.steady)
    setting = dict.fromkeys(shop.tools, 1)
    minutes = dict.fromkeys(shop.tools, 0.0)
    made: list[Made] = []
    taken: dict[str, float] = {}
    for order, moment in enumerate(moments):
        if order in shop.standard_at:
            made.append(_standard(truth, shop, points, order, rng))
        if order in shop.set_anew:
            setting = {tool: count + 1 for tool, count in setting.items()}
            minutes = dict.fromkeys(shop.tools, 0.0)
        if order == shop.corrected_from:
            taken = _learned([one for one in made if not one.standard], points)
        minutes = {tool: spent + shop.minutes_in_cut * rng.uniform(0.9, 1.1) for tool, spent in minutes.items()}
        cut = Cut(order, shop.parts, setting, minutes, _depths(truth, shop, features, rng), shop.minutes_in_cut)
        made.append(_made(truth, shop, features, points, cut, moment, taken, rng))
    return Series(truth, shop, features, points, tuple(made))


def tool_of_points_mm(features: Mapping[str, FeaturePlace], points: Gauged) -> Array:
    """(X_T, Z_T) of the tool that cut each point, (n, 2)."""
    return np.array([TOOLS_MM[features[name].tool] for name in points.feature])


def _made(
    truth: Truth,
    shop: Shop,
    features: Mapping[str, FeaturePlace],
    points: Gauged,
    cut: Cut,
    moment: Moment,
    taken: Mapping[str, float],
    rng: np.random.Generator,
) -> Made:
    """Cut, probed while clamped with the model in force, then measured once it is free and set up elsewhere."""
    left = process_errors(truth, shop.part, features, points, cut, shop.cut_mm, rng)
    tool_mm = tool_of_points_mm(features, points)
    by_machine = _along(points, left_mm(truth, points.at_mm, tool_mm, moment.true_c))
    cooler = {name: value - shop.cooled_k for name, value in moment.true_c.items()}
    while_probed = _along(points, left_mm(truth, points.at_mm, tool_mm, cooler))
    arrived = truth.gain * np.array([taken.get(name, 0.0) for name in points.feature])
    probed = left.clamped_mm + by_machine - while_probed - arrived + _probe(truth, shop, points, rng)
    measured = left.free_mm + by_machine - arrived + _set_up(points, rng) + rng.normal(0, shop.cmm_mm, points.count)
    return Made(cut, moment, {SeenBy.MACHINE: probed, SeenBy.CMM: measured}, taken)


def _standard(truth: Truth, shop: Shop, points: Gauged, order: int, rng: np.random.Generator) -> Made:
    """A calibrated part is probed at the reference temperature: nothing is cut, and the model's errors count."""
    cold = dict.fromkeys(SIGNALS, REFERENCE_C)
    tool_mm = np.tile(np.array(TOOLS_MM[shop.tools[0]]), (points.count, 1))
    read = _probe(truth, shop, points, rng) - _along(points, left_mm(truth, points.at_mm, tool_mm, cold))
    nothing = Cut(order, shop.parts, {}, {}, {})
    return Made(nothing, Moment(0.0, cold, cold), {SeenBy.MACHINE: read}, standard=True)


def _along(points: Gauged, vectors_mm: Array) -> Array:
    found: Array = np.einsum("ij,ij->i", points.normal, vectors_mm)
    return found


def _probe(truth: Truth, shop: Shop, points: Gauged, rng: np.random.Generator) -> Array:
    """What the part probe adds: an offset on radii, lag along the normal, what it moved by before this part, noise."""
    offset = truth.size_mm(Fault.PROBE_OFFSET) * points.normal[:, 0] + truth.size_mm(Fault.PROBE_LAG)
    loose = points.normal @ (truth.size_mm(Fault.PROBE_LOOSE) * rng.standard_normal(2))
    found: Array = offset + loose + rng.normal(0.0, shop.probe_mm, points.count)
    return found


def _set_up(points: Gauged, rng: np.random.Generator) -> Array:
    """Part on the CMM: its frame is out by a shift across and along, and a tilt, another one for every part."""
    across, along, tilt = rng.normal(0, 0.0005), rng.normal(0, 0.002), rng.normal(0, 3e-6)
    radius, z = points.at_mm.T
    side = np.cos(points.angle_rad)
    x, out = points.normal[:, 0] * side, points.normal[:, 1]
    found: Array = x * (across + tilt * z) + out * (along - tilt * side * radius)
    return found


def _depths(
    truth: Truth, shop: Shop, features: Mapping[str, FeaturePlace], rng: np.random.Generator
) -> dict[str, float]:
    """Depth of the finish cut of each feature: stock differs from part to part, a little from feature to feature."""
    whole = rng.uniform(1 - shop.stock, 1 + shop.stock)
    deeper = {"end face": DEEPER} if truth.of(Fault.UNEQUAL_DEPTH) else {}
    return {name: USUAL_DEPTH_MM * whole * rng.uniform(0.95, 1.05) * deeper.get(name, 1.0) for name in features}


def _learned(before: list[Made], points: Gauged) -> dict[str, float]:
    """What is to be taken off each feature: the mean of what the machine saw on the parts before, whole."""
    read = np.mean([one.read_mm[SeenBy.MACHINE] for one in before], axis=0)
    return {name: float(read[points.is_of([name]).astype(bool)].mean()) for name in dict.fromkeys(points.feature)}
