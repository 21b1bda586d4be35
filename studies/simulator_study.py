"""The loop held against the virtual machine: 200 parts of each NIST family at three repeatabilities.

`python -m studies.simulator_study --write` puts the tables into docs/simulator-study.md; half an hour on two cores.
`--between` makes the first of them alone, cuts that differ, beside NIST's metal; with `--shares` the table that tells
process, probe and curve apart; a few minutes each.
"""

import argparse
import itertools
import math
import os
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final, Literal

import numpy as np

from scripts.nist_bands import held, together
from scripts.nist_parts import parts as nist_parts
from scripts.nist_table import corrected
from trueloop.arrays import Array
from trueloop.geometry.profile import Side
from trueloop.jobs.turned.job import read_job
from trueloop.loops.batch import run_batch
from trueloop.statistics import rms
from trueloop.turned.fit.between_cuts import NONE, PRIOR, BetweenCuts
from trueloop.units import UM_PER_MM
from trueloop_lab.loops.turned import Study, Trial, simulate, study, trial_of
from trueloop_lab.simulator.machine import Repeatability
from trueloop_lab.simulator.nose import SAME, Nose
from trueloop_lab.simulator.presets import (
    NOSE_RADIUS_MM,
    TOOL_MM_PER_N,
    WORN_AT_DEG,
    WORN_BY_UM,
    Workshop,
    nist,
    workshop_of,
)

ROOT: Final = Path(__file__).parents[1]
PAGE: Final = ROOT / "docs" / "simulator-study.md"
BEGIN: Final = "<!-- written by studies/simulator_study.py -->\n"
END: Final = "<!-- end of what is written -->\n"
BETWEEN: Final = "<!-- written by studies/simulator_study.py --between -->\n"
SHARES: Final = "<!-- written by studies/simulator_study.py --shares -->\n"
NISTS: Final = ("facetst", "modbas2", "piecs11")
PARTS: Final = (*NISTS, "bush")
WITH_ARCS: Final = ("modbas2", "piecs11", "bush")
SIGMAS_UM: Final = (0.5, 1.2, 3.0)
FINEST_UM: Final = 0.5
NOT_STEEP: Final = 0.2
"""Touches 0.6 mm apart on an arc that scatter by 3 µm ask for slopes that a shop refuses: here all parts count."""
FIRST_SEED: Final = 400_000
FRESH_SEED: Final = 470_000
WAYS: Final = ("loop_mm", "path_mm", "raw_mm")
ALIKE: Final = "Empty `[transfer]`, `cut_to_cut_um = 0`"
"""What the tables of curve, probe and process alone hold for; the preset and jobs have a transfer and a prior."""
AS_SHIPPED: Final = "`[transfer]` of the preset where the finish cut is as NIST's, else empty; prior between cuts"
USUAL: Final = Repeatability(0.0012, 1.0)
UNSEEN: Final = (
    ("0.5 µm from cut to cut", Repeatability(0.0012, 1.0, 0.0005)),
    ("1.2 µm from cut to cut", Repeatability(0.0012, 1.0, 0.0012)),
    ("3.0 µm from cut to cut", Repeatability(0.0012, 1.0, 0.003)),
    ("the 1.2 µm vary over 15 mm instead", Repeatability(0.0012, 15.0)),
)
"""What one part's scatter does not show."""


def boring(repeatability: Repeatability) -> Workshop:
    """The lathe with a boring bar: an insert worn a fifth as much, in a bore at mirrored contact angles.

    The bar gives way by five times as much as an outside tool: an overhang of some four diameters (both assumed).
    """
    angles = tuple(-math.radians(angle) for angle in reversed(WORN_AT_DEG))
    nose = Nose(NOSE_RADIUS_MM, angles, tuple(w / UM_PER_MM / 5.0 for w in reversed(WORN_BY_UM)))
    return workshop_of(nose, 5.0 * TOOL_MM_PER_N, repeatability, SAME)


def main() -> None:
    """Prints the tables, or writes them into the page."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--parts", type=int, default=200, help="parts of each family and repeatability")
    options.add_argument("--write", action="store_true", help="into docs/simulator-study.md")
    options.add_argument("--between", action="store_true", help="cuts that differ, and what the bands hold of them")
    options.add_argument("--shares", action="store_true", help="what is left by process, probe and curve alone")
    given = options.parse_args()
    if given.shares:
        text, begin = shares(given.parts), SHARES
    elif given.between:
        text, begin = between(given.parts), BETWEEN
    else:
        text, begin = "\n".join((residuals(given.parts), by_place(given.parts))), BEGIN
    if not given.write:
        print(text)
        return
    before, rest = PAGE.read_text().split(begin)
    PAGE.write_text(f"{before}{begin}{text}{END}{rest.split(END, 1)[1]}")


def residuals(parts: int) -> str:
    """What is left after one compensation, by way of correcting, and what the bands hold."""
    rows = []
    for name, sigma in itertools.product(PARTS, SIGMAS_UM):
        made = _made(_trial(name), Repeatability(sigma / 1000, 1.0), parts)
        ways = (_relative(made, way, sigma) for way in WAYS)
        rows.append(_told(name.upper(), f"{sigma} µm", *ways, _coverage(made)))
    head = ("", "σ", "the loop", "tangent paths", "each touch for itself", "inside the 95 % band")
    words = (
        f'{ALIKE}, `errors_follow = "nose"`: {parts} parts a row, {_seeds(FIRST_SEED, parts)}; ± is one standard '
        "uncertainty from how the parts differ."
    )
    return f"{words}\n\n{_table(head, rows)}"


def by_place(parts: int) -> str:
    """What the loop leaves of the families with arcs where it is not told that errors follow the nose."""
    rows = []
    for name, sigma in itertools.product(WITH_ARCS, SIGMAS_UM):
        made = _made(_trial(name, "place"), Repeatability(sigma / 1000, 1.0), parts)
        rows.append(_told(name.upper(), f"{sigma} µm", _relative(made, "loop_mm", sigma), _coverage(made)))
    head = ('without `errors_follow = "nose"`', "σ", "the loop", "inside the 95 % band")
    return f"{ALIKE}: {parts} parts a row, {_seeds(FIRST_SEED, parts)}.\n\n{_table(head, rows)}"


def between(parts: int) -> str:
    """What the bands hold where the finish cut does otherwise than the semi-finish cut, with the prior and without."""
    metal = _in_metal()
    rows = [
        _held(
            f"{name.upper()}, finish cut as NIST's",
            _trial(name, between=PRIOR),
            nist(USUAL),
            parts,
            metal[name.upper()],
        )
        for name in NISTS
    ]
    trial = _trial("modbas2", between=PRIOR)
    for words, repeatability in UNSEEN:
        rows.append(_held(f"MODBAS2, {words}", trial, nist(repeatability, SAME), parts, ("", "")))
    head = ("1.2 µm along the cut and …", "inside ±U", "were cuts taken for alike", "NIST's metal", "taken for alike")
    return f"{AS_SHIPPED}: {parts} parts a row, {_seeds(FIRST_SEED, parts)}.\n\n{_table(head, rows)}"


def _held(words: str, trial: Trial, workshop: Workshop, parts: int, metal: tuple[str, str]) -> tuple[str, ...]:
    made = study(trial, workshop, parts, first_seed=FIRST_SEED, workers=os.cpu_count() or 1)
    return _told(words, _coverage(made), _share(made.inside("alike_u_mm")), *metal)


def _in_metal() -> dict[str, tuple[str, str]]:
    """By family: share of NIST's points inside the bands, with the prior and without."""
    each = [(part.family.name, held("", part, corrected(part))) for part in nist_parts()]
    shares = {}
    for name in dict.fromkeys(family for family, _ in each):
        all_of_it = together(name, [one for family, one in each if family == name])
        shares[name] = (f"{100 * all_of_it.inside:.1f} %", f"{100 * all_of_it.inside_without_prior:.1f} %")
    return shares


def shares(parts: int) -> str:
    """What the loop leaves where the process scatters by 0.5 µm, the probe by its ranges, one of them, or neither."""
    still = Repeatability()
    rows = []
    ways: tuple[Literal["place", "nose"], ...] = ("place", "nose")
    for name, follow in itertools.product(NISTS, ways):
        cells = []
        for repeats, exact in itertools.product((Repeatability(FINEST_UM / 1000, 1.0), still), (False, True)):
            workshop = nist(repeats, SAME)
            if exact:
                workshop = replace(workshop, probe=replace(workshop.probe, range_x_mm=0.0, range_z_mm=0.0))
            one = partial(_left_mm, _trial(name, follow), workshop)
            count = parts if repeats is not still or not exact else 1
            made = run_batch(one, range(FRESH_SEED, FRESH_SEED + count), workers=os.cpu_count() or 1)
            cells.append(f"{1000 * rms(np.concatenate(list(made))):.2f} µm")
        rows.append(_told(name.upper(), f'`"{follow}"`', *cells))
    scatters = (f"process {FINEST_UM} µm and probe", "process alone", "probe alone", "neither")
    head = ("left, RMS", "`errors_follow`", *scatters)
    return f"{ALIKE}: {parts} parts a cell, {_seeds(FRESH_SEED, parts)}.\n\n{_table(head, rows)}"


def _seeds(first: int, parts: int) -> str:
    return f"seeds {first} to {first + parts - 1}"


def _left_mm(trial: Trial, workshop: Workshop, seed: int) -> Array:
    return simulate(trial, workshop, seed).finish_truth_mm


def _trial(name: str, errors_follow: Literal["place", "nose"] = "nose", between: BetweenCuts = NONE) -> Trial:
    inputs = read_job(ROOT / "examples" / name / "job.toml").inputs
    limits = replace(inputs.options.limits, slope=NOT_STEEP)
    options = replace(inputs.options, errors_follow=errors_follow, between_cuts=between, limits=limits)
    return trial_of(replace(inputs, options=options))


def _made(trial: Trial, repeatability: Repeatability, parts: int) -> Study:
    inside = trial.inputs.profile.side is Side.INSIDE
    workshop = boring(repeatability) if inside else nist(repeatability, SAME)
    return study(trial, workshop, parts, first_seed=FIRST_SEED, workers=os.cpu_count() or 1)


def _relative(made: Study, way: str, sigma_um: float) -> str:
    unit_mm = sigma_um / 1000 * math.sqrt(2.0)
    return f"{made.rms_mm(way) / unit_mm:.2f} ± {_rms_u_mm(made, way) / unit_mm:.2f}"


def _coverage(made: Study) -> str:
    return _share(made.inside("expanded_u_mm"))


def _share(inside: Array) -> str:
    return f"{100 * np.mean(inside):.1f} ± {100 * _u_of_mean(inside):.1f} %"


def _rms_u_mm(made: Study, way: str) -> float:
    """Returns the standard uncertainty of an RMS, from how the parts differ: points of one part are not independent."""
    squares = np.array([np.mean(getattr(part, way) ** 2) for part in made.parts])
    return _u_of_mean(squares) / (2.0 * made.rms_mm(way))


def _u_of_mean(values: Array) -> float:
    return float(np.std(values, ddof=1) / np.sqrt(len(values))) if len(values) > 1 else float("nan")


def _told(*row: str) -> tuple[str, ...]:
    print(*row, sep=" | ", file=sys.stderr, flush=True)  # so that something is seen of half an hour
    return row


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [head, ("---", *("---:",) * (len(head) - 1)), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


if __name__ == "__main__":
    main()
