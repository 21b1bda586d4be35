"""How well a refined model does on part types that it was not refined from: the tables of docs/refinement-study.md.

The truth is the warm lathe of plain transforms (`trueloop_lab/simulator/lathe.py`), measured and fitted as `trueloop
machine fit` does, which no form of model matches. After the fit it is changed by formulas typed here: a slide wears,
a screw is changed, a headstock is hotter. Parts of some types are then cut with the old model in force; the model is
refined with the guilty errors named; parts of other types say what it is worth.
"""

import argparse
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.formats.examples import example
from trueloop.formats.jobs.machine_toml import read_machine
from trueloop.jobs.machine.machine_model import readings_of
from trueloop.machine.identify.form import fit_form
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.history import Clock, History, lag_signals
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.refine.left import Guilty, LeftOnParts
from trueloop.machine.refine.refine import Refined, left_by, refine
from trueloop.statistics import rms
from trueloop_lab.realtime.demo import angles_csv, lengths_csv, signals_csv
from trueloop_lab.simulator.lathe import UNTIL_S, WarmLathe, WarmUp, measured_day, warm_up
from trueloop_lab.simulator.machine import Backlash

Fault = Callable[[Array, Array, WarmUp], Array]
"""Slides (n, 2), tool (2,), warmth: what the tool point is off by besides, (n, 2) in x, z, as seen from the work."""

LATHE = WarmLathe(lost=Backlash(0.0, 0.0))
NOISE_MM, SET_UP_MM, SLIPS = 0.001, 0.001, 0.01


def _worn_carriage(at: Array, tool: Array, warm: WarmUp) -> Array:
    """The carriage's way is worn in its middle: X by up to 10 µm."""
    del tool, warm
    return np.column_stack([0.010 * np.sin(np.pi * (at[:, 1] + 300) / 410) ** 2, np.zeros(len(at))])


def _hot_headstock(at: Array, tool: Array, warm: WarmUp) -> Array:
    """The headstock grows by 1 µm/K of its bearing more than it did: the tool stands that much less along Z."""
    del tool
    return np.column_stack([np.zeros(len(at)), -0.0010 * (warm.bearing + warm.hall)])


def _yawing_carriage(at: Array, tool: Array, warm: WarmUp) -> Array:
    """The carriage turns by up to 140 µrad about Y; the arm leads from its frame to the tool point."""
    del warm
    turn = 150e-6 * np.tanh(at[:, 1] / 200.0)
    x, z = tool[0] + at[:, 0], np.broadcast_to(tool[1], len(at))
    return np.column_stack([turn * z, -turn * x])


def _other_screw(at: Array, tool: Array, warm: WarmUp) -> Array:
    """A new screw of X: 36 µm over 300 mm and a sine of 0.6 µm."""
    del tool, warm
    u = at[:, 0] / 300
    return np.column_stack(
        [0.036 * u * (1.2 - 0.2 * u) + 0.0006 * np.sin(2 * np.pi * at[:, 0] / 60), np.zeros(len(at))]
    )


def _tilting_headstock(at: Array, tool: Array, warm: WarmUp) -> Array:
    """The work tilts by 10 µrad/K of the casting: by −tilt the tool is turned as seen from it."""
    turn = -10e-6 * (warm.casting + warm.hall)
    x, z = at[:, 0] + tool[0], at[:, 1] + tool[1]
    return np.column_stack([turn * z, -turn * x])


FAULTS: dict[str, tuple[Fault, tuple[Guilty, ...]]] = {
    "carriage worn": (_worn_carriage, (Guilty(error_name("EXZ")),)),
    "headstock hotter": (_hot_headstock, (Guilty(error_name("EZ0C"), "T1"),)),
    "carriage yaws": (_yawing_carriage, (Guilty(error_name("EBZ")),)),
    "other screw of X": (_other_screw, (Guilty(error_name("EXX")),)),
    "headstock tilts": (_tilting_headstock, (Guilty(error_name("EB0C"), "T2"),)),
}


@dataclass(frozen=True)
class PartType:
    """Gauging points in part coordinates, x a radius (n, 2), outward normals (n, 2), the tool that cuts each (n, 2)."""

    at_mm: Array
    normal: Array
    tool_mm: Array


def part_type(rng: np.random.Generator) -> PartType:
    """A shaft with two or three diameters and faces, part of it by another tool; its place in the machine is random."""
    rows = []
    tools = [np.array([-12.0, -30.0]) + rng.uniform(-10, 10, 2), np.array([-60.0, 60.0]) + rng.uniform(-15, 15, 2)]
    z, radius = rng.uniform(-190, -120), rng.uniform(60, 120)
    for k in range(int(rng.integers(2, 4))):
        length, tool = rng.uniform(25, 50), tools[k % 2]
        rows += [(radius, z + t * length, 1.0, 0.0, *tool) for t in np.linspace(0.1, 0.9, 8)]
        inner = max(radius - rng.uniform(15, 35), 5.0)
        z += length
        rows += [(radius - t * (radius - inner), z, 0.0, 1.0, *tool) for t in np.linspace(0.15, 0.85, 5)]
        radius = inner
    cone = np.array([np.cos(0.5), np.sin(0.5)])
    rows += [(radius - 4 * t * np.tan(0.5), z + 4 * t, *cone, *tools[0]) for t in np.linspace(0.2, 1, 4)]
    table = np.array(rows)
    return PartType(table[:, :2], table[:, 2:4], table[:, 4:])


def fitted(seed: int = 0) -> MachineModel:
    """The lathe's model as it was before the fault, from a day of measuring."""
    with tempfile.TemporaryDirectory() as name:
        folder, (day, readings) = Path(name), measured_day(LATHE, seed)
        logged = day.at(np.arange(0.0, UNTIL_S, 0.5))
        texts = {"lengths.csv": lengths_csv(readings), "angles.csv": angles_csv(readings)}
        texts["day.csv"] = signals_csv(logged.time_s, logged.sensors(np.random.default_rng(seed + 2)))
        for file, text in texts.items():
            (folder / file).write_text(text)
        machine, form = read_machine(example("realtime/machine.toml"))
        data = readings_of([folder / "lengths.csv", folder / "angles.csv"], machine.chain, folder / "day.csv")
        return fit_form(machine, form, data)[0].model


class Shop:
    """Cuts parts of the types in turn with COMP_MTG = −E_model, at temperatures of random days, and inspects them."""

    def __init__(self, model: MachineModel, faults: list[Fault], seed: int, *, scatter: bool = True) -> None:
        self.model, self.faults, self.scatter = model, faults, scatter
        self.rng = np.random.default_rng(seed)

    def parts(self, types: dict[int, PartType], count: int) -> LeftOnParts:
        """As many parts, what was left on them along the normals: ERROR_MTG,RESID."""
        made = [self._part(k, number, types[number]) for k, number in zip(range(count), _in_turn(types), strict=False)]
        columns = [np.concatenate([np.atleast_1d(one[j]) for one in made]) for j in range(6)]
        signals = {name: np.concatenate([one[6][name] for one in made]) for name in made[0][6]}
        part, kind, normal, at, tool, left = columns
        return LeftOnParts(part, kind, normal, State(at, 0.0, signals, tool), left, NOISE_MM)

    def _part(self, part: int, number: int, one: PartType) -> tuple:  # type: ignore[type-arg]
        n, rng = len(one.at_mm), self.rng
        warm, signals = self._warmth(n)
        drives = one.at_mm - one.tool_mm
        compensated = drives - self._model_error(drives, one.tool_mm, signals)
        surface = np.empty_like(drives)
        for tool in np.unique(one.tool_mm, axis=0):
            own = (one.tool_mm == tool).all(axis=1)
            true = LATHE.error_mm(compensated[own], tool, _some(warm, own))
            true = true + sum(fault(compensated[own], tool, _some(warm, own)) for fault in self.faults)
            surface[own] = compensated[own] + tool + true
        left = np.einsum("ni,ni->n", one.normal, surface - one.at_mm)
        if self.scatter:
            slipped = rng.normal(0, 0.03, n) * (rng.random(n) < SLIPS)
            left = left + one.normal @ rng.normal(0, SET_UP_MM, 2) + rng.normal(0, NOISE_MM, n) + slipped
        spread = np.zeros((n, 3))
        spread[:, [0, 2]] = one.normal
        tool3 = np.zeros((n, 3))
        tool3[:, [0, 2]] = one.tool_mm
        return np.full(n, part), np.full(n, number), spread, drives, tool3, left, signals

    def _model_error(self, drives: Array, tool: Array, signals: dict[str, Array]) -> Array:
        tool3 = np.column_stack([tool[:, 0], np.zeros(len(tool)), tool[:, 1]])
        return self.model.error_mm(State(drives, 0.0, signals, tool3))[:, [0, 2]]

    def _warmth(self, n: int) -> tuple[WarmUp, dict[str, Array]]:
        begin, rest = self.rng.uniform(0, 60), self.rng.uniform(5, 60)
        day = warm_up(200.0, ((begin, begin + rest),), ((begin, begin + rest),))
        log = History(day.time_s, day.sensors(self.rng))
        moment = np.linspace(0.0, 2.0, n) + self.rng.uniform(10, 190)
        every = np.arange(len(day.time_s))
        lagged = lag_signals(self.model.lags, Clock(day.time_s, np.zeros(len(every), dtype=np.intp), (log,)))
        known = {**log.signals, **lagged}
        return day.at(moment), {name: np.interp(moment, day.time_s, values) for name, values in known.items()}


def _in_turn(types: dict[int, PartType]) -> list[int]:
    return list(types) * 100


def _some(warm: WarmUp, own: Flags) -> WarmUp:
    return WarmUp(*(getattr(warm, name)[own] for name in WarmUp.__dataclass_fields__))


@dataclass(frozen=True)
class Trial:
    """Of one refinement: what old and new model truly left on the types left out, and its own judgement.

    `u_mm` is the standard uncertainty that the new model gives itself there, RMS.
    """

    old_mm: float
    new_mm: float
    u_mm: float
    refined: Refined


def trial(model: MachineModel, names: list[str], guilty: tuple[Guilty, ...], seed: int, parts: int = 20) -> Trial:
    """Refines from `parts` parts of three types and looks at fifteen of three others."""
    rng = np.random.default_rng(seed)
    types = {k: part_type(rng) for k in range(6)}
    faults = [FAULTS[name][0] for name in names]
    seen = Shop(model, faults, seed + 1).parts({k: types[k] for k in range(3)}, parts)
    others = Shop(model, faults, seed + 2, scatter=False).parts({k: types[k] for k in range(3, 6)}, 15)
    found = refine(model, seen, guilty)
    new = left_by(model, found.model, others)
    along = np.einsum("ni,nij->nj", others.normal, found.model.sensitivities(others.state))
    u = float(np.sqrt(np.mean(np.einsum("nj,jk,nk->n", along, found.model.covariance, along))))
    return Trial(rms(others.residual_mm), rms(new), u, found)


def main() -> None:
    """Prints a row a fault."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--trials", type=int, default=10)
    count = parser.parse_args().trials
    model = fitted()
    cases = [[name] for name in FAULTS] + [
        ["carriage worn", "headstock hotter"],
        ["carriage yaws", "other screw of X"],
        [],
    ]
    print("| fault after the fit | left by old | by refined | halved | worse beyond u | offered |")
    print("|---|---|---|---|---|---|")
    for names in cases:
        guilty = tuple(one for name in names for one in FAULTS[name][1])
        done = [trial(model, names, guilty, 100 * k + 7) for k in range(count)]
        halved = np.mean([one.new_mm <= 0.5 * one.old_mm for one in done])
        worse = np.mean([one.new_mm > one.old_mm + one.u_mm for one in done])
        old, new = (1e3 * np.median([getattr(one, name) for one in done]) for name in ("old_mm", "new_mm"))
        offered = np.mean([one.refined.judged.better for one in done])
        name = " and ".join(names) or "none"
        print(f"| {name} | {old:.2f} µm | {new:.2f} µm | {halved:.0%} | {worse:.0%} | {offered:.0%} |", flush=True)


if __name__ == "__main__":
    main()
