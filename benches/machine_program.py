"""A million blocks corrected by a 21-term machine model, beside LinuxCNC's `rs274 -g`, which only reads and runs them.

Run: .venv/bin/python -m benches.machine_program
"""

import tempfile
from pathlib import Path

import numpy as np

from benches.machine_evaluator import mill_model
from benches.nc_program import EVERYWHERE, RS274, milling_program
from benches.ratio import Contender, compare, process
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.machine.correct import Setup, compensation_field

BLOCKS = 1_000_000
SETUP = Setup({1: (250.0, 0.0, -100.0)})


def main() -> None:
    """Corrected and written, half a micrometre of tolerance, the record's id included."""
    field = compensation_field(mill_model(np.random.default_rng(8)), SETUP, {})
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "milled.ngc"
        program.write_text(milling_program(BLOCKS))
        out = program.with_suffix(".out.ngc")
        ours = Contender(
            "trueloop machine compensate", lambda: map_program(program, out, field, EVERYWHERE, dialect="linuxcnc")
        )
        compare(
            f"{BLOCKS:,} blocks, {program.stat().st_size / 1e6:.0f} MB",
            [ours, Contender(RS274, process("rs274", "-g", program))],
            rounds=2,
        )


if __name__ == "__main__":
    main()
