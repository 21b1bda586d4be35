"""Sends programs over a serial line in which everything goes wrong: `python -m scripts.line_transfers [COUNT [SEED]]`.

A control of another hand (`tests/support/serial_control.py`) with a buffer of 256 bytes holds the line at random, in
ASCII, ISO and EIA code, by XON/XOFF and RTS/CTS. Prints a tally as JSON: how each fault ended, and what must be none.
"""

import json
import random
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Final, Literal

from tests.support.serial_control import FAULTS, Fault, SerialControl, VirtualLine
from trueloop.controllers.links.compare import Change
from trueloop.controllers.links.line import LineCode
from trueloop.errors import TrueloopError
from trueloop.jobs.links import Opened, send

CODES: Final[tuple[LineCode, ...]] = ("ascii", "iso", "eia")
FLOWS: Final[tuple[Literal["xon-xoff", "rts-cts"], ...]] = ("xon-xoff", "rts-cts")
BAUD = 9600
BITS = 11


def main(count: int = 10_000, seed: int = 1) -> None:
    """The tally of so many transfers."""
    ended: Counter[str] = Counter()
    wrong: Counter[str] = Counter(
        {"lost bytes": 0, "sent too early": 0, "half a program": 0, "said to be there": 0, "too many after XOFF": 0}
    )
    with tempfile.TemporaryDirectory() as folder:
        for k in range(count):
            fault, code, found = transfer(seed * 1_000_000 + k, Path(folder))
            ended[f"{fault}: {code}"] += 1
            wrong.update(found)
    print(json.dumps({"transfers": count, "ended": dict(sorted(ended.items())), "wrong": dict(wrong)}, indent=1))


def transfer(seed: int, folder: Path) -> tuple[Fault, str, list[str]]:
    """One transfer: its fault, how it ended ("sent", or a code), and what must not be."""
    drawn = random.Random(seed)
    fault, program = drawn.choice(FAULTS), program_of(drawn)
    code, flow, after = drawn.choice(CODES), drawn.choice(FLOWS), drawn.choice((4, 10, 40))
    control = SerialControl(code, flow, BITS / BAUD, after, seed, fault)

    def tell(said: str) -> None:
        if "read now" in said:
            control.let_read()
        else:
            control.put_out()

    line = VirtualLine(
        *("virtual", BAUD),
        data_bits=8,
        parity="none",
        flow=flow,
        code=code,
        after_xoff=after,
        silence_s=30.0,
        tell=tell,
        control=control,
    )
    passes = frozenset({Change.CAPITALS} if code == "eia" else set[Change]())
    outcome = "sent"
    try:
        send(Opened("old", line, passes, folder), program, "O1")
    except TrueloopError as refused:
        outcome = refused.code.value
    whole = "\n".join(["%", program.decode().strip(), "%", ""])
    found = ["lost bytes"] * bool(control.lost) + ["too many after XOFF"] * (control.most_after > after)
    found += ["sent too early"] * (control.early > 0)
    found += ["half a program"] * (control.memory not in (None, whole))
    found += ["said to be there"] * (outcome == "sent" and control.memory != whole)
    return fault, outcome, found


def program_of(drawn: random.Random) -> bytes:
    """Some blocks, short and long ones."""
    blocks = ["O1 (" + "FINISH" + ")"]
    for k in range(drawn.randrange(12, 60)):
        blocks.append(f"N{k * 10} G1 X{drawn.uniform(0, 99):.3f} Z-{drawn.uniform(0, 99):.4f} F.2")
    return "\n".join([*blocks, "M30", ""]).encode()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
