"""The whole command, from process start to files written, beside merely importing what anything numerical needs."""

import sys
import tempfile
from pathlib import Path

from benches.ratio import Contender, compare, process, verdict

TRUELOOP = Path(sys.executable).with_name("trueloop")
JOB = Path(__file__).parents[1] / "examples" / "modbas2" / "job.toml"
IMPORTS = "import numpy, scipy.interpolate"
HELP_AIM_S = 0.3


def main() -> None:
    """Compare `trueloop compensate` and `trueloop --help` with the imports alone."""
    with tempfile.TemporaryDirectory() as folder:
        compensate = Contender("trueloop compensate", process(TRUELOOP, "compensate", JOB, "--output", folder))
        help_page = Contender("trueloop --help", process(TRUELOOP, "--help"))
        imports = Contender(f"python -c '{IMPORTS}'", process(sys.executable, "-c", IMPORTS))
        samples = compare("Process start to files written, MODBAS2", [compensate, help_page, imports])
    verdict(samples, compensate.name, to=imports.name, at_most=3)
    help_s = samples.median_s(help_page.name)
    print(f"{help_page.name} takes {help_s:.2f} s: {'within' if help_s <= HELP_AIM_S else 'MISSES'} {HELP_AIM_S} s")


if __name__ == "__main__":
    main()
