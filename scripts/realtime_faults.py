"""Ten thousand faults while LinuxCNC moves at 50 mm/s with the corrector: `python -m scripts.realtime_faults [COUNT]`.

Signals lost, not a number, jumping, beyond their range; the signals' component silent; images exchanged, also bad ones;
enable toggled, the emergency stop, abort, homing, settings that make no sense. Each comes at a moment drawn by chance,
for 0 to 60 ms. Every servo period is judged by the machine model in splines: position error against that without the
corrector, the step of the correction against its slew, and whether the pins say why it is not in force. Prints the
findings as JSON; ends with 1 where there is one.
"""

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.linalg import block_diag

from trueloop.arrays import Array, Flags
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import Part, chain_of, segments, turning_terms
from trueloop.realtime.image import Identity, Image, RealTimeLimits, SignalLimits, bank_of, signals_of
from trueloop.realtime.judge import travel_ways
from trueloop_lab.linuxcnc.realtime import session
from trueloop_lab.linuxcnc.realtime.session import Driven, Setup, Step, put, sleep

TRAVEL: Final = {"X": (-10.0, 400.0), "Z": (-250.0, 200.0)}
WARM: Final = {"T1": 27.5, "T2": 19.25}
TOOL: Final = (50.0, 0.0, -40.0)
SLEW_MM: Final = 5.0e-3
"""A period: 5 mm/s."""
ROUNDING_MM: Final = 1e-6
IN_FORCE: Final = (2, 3)
SAMPLED: Final = (
    *("joint.0.pos-cmd", "joint.1.pos-cmd", "joint.0.motor-offset", "joint.1.motor-offset"),
    *("rtec.out-0", "rtec.out-2", "rtec.phase", "rtec.fault-code", "rtec.waits-for", "rtec.signal-fault"),
    *("rtec.generation", "rtec.enable", "rtec.reload-error", "rtec.periods"),
)
PROGRAM: Final = b"G21 G18 G8 G90 G94 G64 P0.001 Q0\n" + 400 * (
    b"G1 X40 Z-20 F3000\nG1 X70 Z-110\nG1 X20 Z-110\nG0 X60 Z5\nG2 X80 Z-15 I0 K-20 F3000\nG1 X41 Z10\n"
)
PROGRAM_END: Final = b"M2\n"

Kind = Callable[[np.random.Generator], Sequence[Step]]


def lathe(seed: int) -> MachineModel:
    """Some 60 µm of errors, forward and return apart, two temperatures."""
    chain = chain_of("turning")
    chain = chain.with_axes({a.name: replace(a, travel=TRAVEL[a.name]) for a in chain.axes if a.name in TRAVEL})
    warm = {"EXX": ("X", "T1", 20.0), "EZZ": ("Z", "T2", 22.0)}
    terms = []
    for term in turning_terms(chain, degree=3, count=3, both_ways=True):
        axis, signal, reference = warm.get(str(term.name), ("", "", 0.0))
        more = (Part(segments(*TRAVEL[axis], 1, 1, (0.0,)), signal, reference),) if axis else ()
        terms.append(replace(term, parts=(*term.parts, *more)))
    free = block_diag(*[term.admissible() for term in terms])
    size = np.concatenate([np.full(t.size, 15e-6 if t.name.is_rotation else 0.008) for t in terms])
    drawn = np.random.default_rng(seed).normal(0, 1, len(size)) * size
    return MachineModel(Machine("lathe", chain), tuple(terms), free @ (free.T @ drawn), np.zeros((len(size),) * 2))


def image(model: MachineModel) -> bytes:
    """As the component loads it."""
    stated = SignalLimits({"T1": (10.0, 45.0), "T2": (10.0, 45.0)}, {"T1": 2.0, "T2": 2.0})
    limits = RealTimeLimits((TRAVEL["X"], (-1.0, 1.0), TRAVEL["Z"]), limit_mm=0.3)
    return image_to_bytes(Image(Identity("lathe", ""), limits, bank_of(model, TOOL, signals_of(model, stated))))


def _while(name: str, bad: float | str, good: float) -> Kind:
    def steps(rng: np.random.Generator) -> Sequence[Step]:
        return [put(name, bad), sleep(rng.uniform(0.0, 0.06)), put(name, good), *again(rng)]

    return steps


def again(rng: np.random.Generator) -> Sequence[Step]:
    """Enable off and on, sometimes before the correction is at zero."""
    return [put("rtec.enable", 0), sleep(rng.uniform(0.0, 0.03)), put("rtec.enable", 1)]


def exchange(rng: np.random.Generator) -> Sequence[Step]:
    """The other image is offered while in force, and taken once off; `NEXT` becomes one of both in turn."""
    return [
        *(
            ("put", "NEXT", "image.rtec"),
            put("rtec.reload", 1),
            sleep(0.03 + rng.uniform(0, 0.02)),
            put("rtec.reload", 0),
        ),
        *(put("rtec.enable", 0), session.wait("rtec.active", 0), sleep(0.03), put("rtec.enable", 1)),
    ]


def bad_image(rng: np.random.Generator) -> Sequence[Step]:
    """Half a file."""
    return [("put", "half.rtec", "image.rtec"), put("rtec.reload", 1), sleep(0.05), put("rtec.reload", 0), *again(rng)]


def stop(rng: np.random.Generator) -> Sequence[Step]:
    """The emergency stop in the middle of the motion."""
    return [("estop",), sleep(rng.uniform(0.0, 0.06)), session.on(), ("start", "part.ngc")]


def abort(rng: np.random.Generator) -> Sequence[Step]:
    """The stop button."""
    return [("abort",), sleep(rng.uniform(0.0, 0.06)), ("start", "part.ngc")]


def homing(rng: np.random.Generator) -> Sequence[Step]:
    """Homed anew, which LinuxCNC does not do while a correction is in force."""
    return [
        *(("abort",), put("rtec.enable", 0), session.wait("rtec.active", 0), ("start_home", -1)),
        *(sleep(rng.uniform(0.0, 0.06)), put("rtec.enable", 1), session.wait("motion.is-all-homed", 1)),
        *(sleep(0.2), ("start", "part.ngc")),
    ]


KINDS: Final[dict[str, tuple[float, Kind]]] = {
    "signal lost": (0.12, _while("rtec.age-0", 20.0, 0.0)),
    "not a number": (0.12, _while("rtec.signal-1", "nan", WARM["T2"])),
    "jump": (0.12, _while("rtec.signal-0", WARM["T1"] + 5.0, WARM["T1"])),
    "out of range": (0.12, _while("rtec.signal-0", 9999.0, WARM["T1"])),
    "silent": (0.10, _while("rtec.watchdog", 0.02, 1e6)),
    "limit too small": (0.06, _while("rtec.limit", 0.001, 0.3)),
    "slew of no number": (0.06, _while("rtec.slew", "nan", 5.0)),
    "toggled": (0.13, again),
    "image exchanged": (0.05, exchange),
    "bad image": (0.04, bad_image),
    "emergency stop": (0.03, stop),
    "abort": (0.03, abort),
    "homing": (0.02, homing),
}


@dataclass(frozen=True)
class Plan:
    """Steps of a session, how often each kind comes, and the images by generation."""

    steps: list[Step]
    counts: dict[str, int]
    images: list[int]


def plan(count: int, seed: int) -> Plan:
    """Faults drawn by chance, with some undisturbed motion before each."""
    rng = np.random.default_rng(seed)
    names, shares = list(KINDS), np.array([share for share, _ in KINDS.values()])
    steps: list[Step] = [session.on(), session.home(), put("rtec.heartbeat", 1), *_settings(), put("rtec.enable", 1)]
    steps += [session.record(), ("start", "part.ngc"), session.wait("rtec.phase", 3)]
    counts, images = dict.fromkeys(names, 0), [0, 0]
    for name in rng.choice(names, count, p=shares / shares.sum()):
        counts[str(name)] += 1
        steps.append(sleep(rng.uniform(0.0, 0.04)))
        for step in KINDS[str(name)][1](rng):
            if step[1:2] == ("NEXT",):
                images.append(1 - images[-1])
            steps.append(tuple(f"model-{images[-1]}.rtec" if word == "NEXT" else word for word in step))
    return Plan([*steps, ("abort",), put("rtec.enable", 0), session.wait("rtec.active", 0)], counts, images)


def _settings() -> Sequence[Step]:
    """Times so short that a fault of 60 ms goes through all stages."""
    given = {"limit": 0.3, "freeze": 0.01, "leave": 0.02, "stale": 10.0, "pause-program": 0, "slew": 5.0}
    signals = {f"signal-{k}": value for k, value in enumerate(WARM.values())}
    return [put(f"rtec.{name}", value) for name, value in {**given, **signals}.items()]


def judged(driven: Driven, models: Sequence[MachineModel], images: Sequence[int]) -> dict[str, float]:
    """Findings, period by period."""
    command = np.column_stack([driven["joint.0.pos-cmd"], driven["joint.1.pos-cmd"]])
    offset = np.column_stack([driven["joint.0.motor-offset"], driven["joint.1.motor-offset"]])
    correction = np.column_stack([driven["rtec.out-0"], driven["rtec.out-2"]]) - offset - command
    way = travel_ways(command)
    which = np.array(images)[driven["rtec.generation"].astype(int)]
    bare, left = np.zeros((2, *command.shape))
    for k, model in enumerate(models):
        bare[which == k] = error_mm(model, command[which == k], way[which == k])
        left[which == k] = error_mm(model, (command + correction)[which == k], way[which == k])
    left += correction
    turning = reversing(way, bare)
    excess = np.linalg.norm(left, axis=1) - np.linalg.norm(bare, axis=1)
    steps = np.abs(np.diff(correction, axis=0)).max(axis=1)
    same_homing = ~np.any(np.diff(offset, axis=0) != 0.0, axis=1)
    enabled = driven["rtec.enable"] == 1
    silent = enabled & ~np.isin(driven["rtec.phase"], IN_FORCE)
    reasons = (driven["rtec.fault-code"] != 0) | (driven["rtec.waits-for"] != 0) | (driven["rtec.signal-fault"] != 0)
    in_force = (driven["rtec.phase"] == IN_FORCE[1]) & ~turning
    return {
        "periods": len(command),
        "missed": int((np.diff(driven["rtec.periods"]) != 1).sum()),
        "error_without_um_rms": rms_um(bare),
        "error_in_force_nm_rms": 1e3 * rms_um(left[in_force]),
        "periods_within_reversals": int(turning.sum()),
        "worse_than_without": int((excess[~turning] > ROUNDING_MM).sum()),
        "largest_excess_nm": float(1e6 * excess[~turning].max()),
        "steps_beyond_slew": int((steps[same_homing] > SLEW_MM + ROUNDING_MM).sum()),
        "largest_step_um": float(1e3 * steps[same_homing].max()),
        "without_a_reason": int((silent & ~reasons).sum()),
        "not_finite": int((~np.isfinite(correction)).sum()),
        "images_taken": int(driven["rtec.generation"].max()) - 1,
        "images_refused": int((np.diff(driven["rtec.reload-error"]) > 0).sum()),
    }


def reversing(way: Array, bare: Array) -> Flags:
    """Periods in which the slew alone keeps the correction behind a backlash that an axis' reversal flips."""
    flags = np.zeros(len(way), dtype=bool)
    for k in np.flatnonzero(np.any(way[1:] != way[:-1], axis=1)) + 1:
        jump = np.abs(bare[k] - bare[k - 1]).max() + np.abs(bare[max(k - 30, 0) : k + 30]).max() * 1e-3
        flags[k : k + int(np.ceil(jump / SLEW_MM)) + 2] = True
    return flags


def error_mm(model: MachineModel, at_mm: Array, way: Array) -> Array:
    """E in x and z, (n, 2), of the warm machine."""
    chain = model.machine.chain
    columns = [chain.order.index("X"), chain.order.index("Z")]
    travel = np.zeros((len(at_mm), len(chain.order)))
    travel[:, columns] = way
    positions = chain.positions({"X": at_mm[:, 0], "Z": at_mm[:, 1]})
    return model.error_mm(State(positions, travel, WARM, TOOL))[:, [0, 2]]


def rms_um(vectors: Array) -> float:
    """Of lengths."""
    return float(1e3 * np.sqrt(np.mean(np.sum(vectors**2, axis=1)))) if len(vectors) else float("nan")


def main(count: int = 10_000, seed: int = 19) -> int:
    """Runs and judges; 1 where something is wrong."""
    models, drawn = [lathe(6517), lathe(4773)], plan(count, seed)
    images = [image(model) for model in models]
    files = {f"model-{k}.rtec": content for k, content in enumerate(images)}
    files |= {"half.rtec": images[1][: len(images[1]) // 2], "part.ngc": PROGRAM + PROGRAM_END}
    setup = Setup(images[0], files, SAMPLED, session.QUIET, depth=400 * count + 60_000)
    driven = session.drive(setup, drawn.steps)
    found = {"faults": drawn.counts, **judged(driven, models, drawn.images)}
    print(json.dumps(found, indent=1))
    wrong = ("worse_than_without", "steps_beyond_slew", "without_a_reason", "not_finite")
    return int(any(found[name] for name in wrong))


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
