"""Stated probabilities of characteristics held against the virtual machine, which knows what became of each part.

`python -m studies.characteristic_study --write` puts the table into docs/tolerances.md; some minutes on two cores.
"""

import argparse
import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.job import read_job
from trueloop.loops.batch import run_batch
from trueloop.turned.characteristics.measurand import Measurand, measurand, profile_has
from trueloop.turned.fit.between_cuts import NONE, PRIOR, BetweenCuts
from trueloop_lab.loops.turned import SimulatedPart, Trial, simulate, trial_of
from trueloop_lab.simulator.machine import Repeatability
from trueloop_lab.simulator.nose import SAME, Transfer
from trueloop_lab.simulator.presets import Workshop, nist

ROOT: Final = Path(__file__).parents[1]
PAGE: Final = ROOT / "docs" / "tolerances.md"
BEGIN: Final = "<!-- written by studies/characteristic_study.py -->\n"
END: Final = "<!-- end of what is written -->\n"
FIRST_SEED: Final = 500_000
BINS: Final = (0.0, 0.2, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)
HALF_ZONES_UM: Final = (2.0, 3.0, 4.5, 6.0, 8.0, 11.0, 15.0)
OFF_UM: Final = (0.0, 2.5, -4.0)
"""Limits are drawn about the nominal and beside it: one side of the zone then counts more than the other."""
ASKED: Final = {
    "facetst": (
        ("a diameter at a place", Characteristic("", Quantity.DIAMETER, "small-cylinder", 0.0, at_z_mm=-20.0), 1.0),
        ("a diameter everywhere", Characteristic("", Quantity.DIAMETER, "large-cylinder", 0.0), 1.5),
        ("a length between faces", Characteristic("", Quantity.LENGTH, "step-face", 0.0, other="end-face"), 0.5),
    ),
    "modbas2": (
        ("a diameter at a place", Characteristic("", Quantity.DIAMETER, "cone", 0.0, at_z_mm=-140.0), 1.0),
        ("a diameter everywhere", Characteristic("", Quantity.DIAMETER, "main-cylinder", 0.0), 1.5),
        ("a radius", Characteristic("", Quantity.RADIUS, "dome", 0.0), 0.7),
        ("the angle of a cone", Characteristic("", Quantity.ANGLE, "cone", 0.0), 0.5),
        ("a form", Characteristic("", Quantity.FORM, "main-cylinder", 0.0), 0.7),
    ),
}
"""By family: kind, characteristic, and by how much its limits are wider than those above; of angles in degrees a µm."""


@dataclass(frozen=True)
class World:
    """What the finish cut does otherwise, and what the loop is to assume of it."""

    words: str
    cut_to_cut_mm: float
    along_mm: float
    assumed: BetweenCuts


WORLDS: Final = (
    World("equal cuts, assumed to be equal", 0.0, 0.0, NONE),
    World("cuts that differ as in the prior", PRIOR.common_mm, PRIOR.scatter_difference_mm, PRIOR),
)


def main() -> None:
    """Prints the table, or writes it into the page."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--parts", type=int, default=200, help="parts of each family")
    options.add_argument("--write", action="store_true", help="into docs/tolerances.md")
    given = options.parse_args()
    text = "\n".join(table(world, given.parts) for world in WORLDS)
    if not given.write:
        print(text)
        return
    before, rest = PAGE.read_text().split(BEGIN)
    PAGE.write_text(f"{before}{BEGIN}{text}{END}{rest.split(END, 1)[1]}")


def table(world: World, parts: int) -> str:
    """Shares inside the limits by the stated probability, a row a kind of characteristic."""
    stated: dict[str, list[tuple[float, bool]]] = {}
    for name in ASKED:
        made = run_batch(partial(outcomes, _trial(name, world), name, world), range(FIRST_SEED, FIRST_SEED + parts),
                         workers=os.cpu_count() or 1)  # fmt: skip
        for one in made:
            for kind, probability, inside in one:
                stated.setdefault(kind, []).append((probability, inside))
    stated["all"] = [pair for pairs in list(stated.values()) for pair in pairs]
    rows = [("stated", *(f"{100 * a:g} to {100 * b:g} %" for a, b in itertools.pairwise(BINS)))]
    rows.append(("---", *("---:" for _ in BINS[1:])))
    rows += [(kind, *_shares(pairs)) for kind, pairs in stated.items()]
    lines = "".join(f"| {' | '.join(row)} |\n" for row in rows)
    return f"{world.words[:1].upper()}{world.words[1:]}, {parts} parts of each family:\n\n{lines}"


def outcomes(trial: Trial, name: str, world: World, seed: int) -> list[tuple[str, float, bool]]:
    """One part: kind, stated probability of being in, and whether it is, of every characteristic."""
    part = simulate(trial, _workshop(world, seed), seed)
    kinds = [kind for kind, *_ in ASKED[name] for _ in range(len(HALF_ZONES_UM) * len(OFF_UM))]
    return [
        (kind, one.after.probability_in or 0.0, _is_in(trial, part, one.characteristic))
        for kind, one in zip(kinds, part.correction.characteristics, strict=True)
    ]


def _is_in(trial: Trial, part: SimulatedPart, asked: Characteristic) -> bool:
    """By the true errors of the finished part, at the places that the characteristic is judged at."""
    touches = np.bincount(part.touches.feature_index, minlength=len(trial.inputs.profile.features))
    sizes = measurand(trial.inputs.profile, asked, touches)
    values = sizes.nominal + sizes.gains @ _true_mm(trial, part, sizes)
    if asked.quantity is Quantity.FORM:
        values = np.array([np.ptp(values)])
    low, high = asked.lower_limit, asked.upper_limit
    return bool((low is None or values.min() >= low) and (high is None or values.max() <= high))


def _true_mm(trial: Trial, part: SimulatedPart, sizes: Measurand) -> Array:
    """True part errors at the places, the part's z taken from the reference point."""
    features, touches = trial.inputs.profile.features, trial.inputs.touches
    pairs = list(zip(sizes.feature_index.tolist(), sizes.arc_length_mm.tolist(), strict=True))
    at = np.array([features[i].point_mm(s) for i, s in pairs])
    normal = np.array([features[i].outward_normal(s) for i, s in pairs])
    error = part.finished.height_mm(at, normal)
    if trial.z_reference is None:
        return error
    k = touches.point.index(trial.z_reference)
    zero = part.finished.height_mm(touches.nominal_mm[k : k + 1], touches.outward_normal[k : k + 1])
    return np.asarray(error - normal[:, 1] / touches.outward_normal[k, 1] * zero[0])


def _workshop(world: World, seed: int) -> Workshop:
    """The NIST machine; the finish cut errs by contact angle as no other part's does, drawn by the seed."""
    workshop = nist(Repeatability(0.0012, 1.0, world.cut_to_cut_mm), SAME)
    rng, angles = np.random.default_rng([seed, 7]), np.radians(np.arange(-30.0, 151.0, 30.0))
    errors = world.along_mm * rng.standard_normal(len(angles))
    transfer = Transfer(tuple(angles.tolist()), tuple(errors.tolist())) if world.along_mm else SAME
    return replace(workshop, machine=replace(workshop.machine, transfer=transfer))


def _trial(name: str, world: World) -> Trial:
    inputs = read_job(ROOT / "examples" / name / "job.toml").inputs
    options = replace(inputs.options, errors_follow="nose", between_cuts=world.assumed)
    asked = tuple(limited for _, one, wider in ASKED[name] for limited in _limits(one, wider, inputs.profile))
    inputs = replace(inputs, options=options, characteristics=asked)
    return trial_of(inputs, inputs.inspections[0].z_reference)


def _limits(asked: Characteristic, wider: float, profile: Profile) -> Iterator[Characteristic]:
    """The characteristic with many limits; of a form the upper one alone counts."""
    nominal = profile_has(asked, profile)
    for half_um, off_um in itertools.product(HALF_ZONES_UM, OFF_UM):
        half, off = 1e-3 * wider * half_um, 1e-3 * wider * off_um
        yield replace(asked, nominal=nominal, lower_limit=nominal + off - half, upper_limit=nominal + off + half)


def _shares(pairs: list[tuple[float, bool]]) -> Iterator[str]:
    probability, inside = np.array([one for one, _ in pairs]), np.array([one for _, one in pairs])
    for low, high in itertools.pairwise(BINS):
        rows = (probability >= low) & ((probability < high) | (high == 1.0))
        count = int(np.count_nonzero(rows))
        yield f"{100 * np.mean(inside[rows]):.0f} % of {count}" if count >= 20 else "–"


if __name__ == "__main__":
    main()
