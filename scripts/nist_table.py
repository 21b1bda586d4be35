"""Runs every part of [6811] through the process-intermittent loop and writes the table docs/nist-parts.md.

`python -m scripts.nist_table` prints the page, `--write` writes it, with the touches of the example jobs.
"""

import argparse
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from scripts.nist_bands import section
from scripts.nist_parts import NistPart, example_touches, parameters, parts, program, touches_csv
from trueloop.arrays import Array
from trueloop.formats.jobs.profile_of_job import part_table_toml
from trueloop.geometry.feature import Arc
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM

PAGE: Final = Path(__file__).parents[1] / "docs" / "nist-parts.md"

HEAD: Final = """# Fourteen parts of metal

NISTIR 6811 reports fourteen parts, each measured after the semi-finish cut and again after a finish cut that its
authors had corrected: four FACETST (two cylinders, two faces, tapers cut on purpose), four MODBAS2 (dome tangent to a
cylinder) and six PIECS11 (knob on a cone), the last two families with a worn insert. Here trueloop is given the same
touches after the semi-finish cut, Tables 4, 8 and 10, with a job and programs made as in `examples/`.

- **Semi-finish**: root mean square of the measured errors, µm, material left on or taken too much.
- **NIST's finish**: the same after NIST's corrected finish cut, Tables 7, 9 and 11. Measured.
- **Predicted**: what trueloop's correction is expected to leave at the same points, were the finish cut to err exactly
  as the semi-finish cut did. No metal was cut: real cuts repeat to some micrometres, and NIST's numbers contain that
  ([Do the bands hold on metal?](#do-the-bands-hold-on-metal)).
- **Left out**: the prediction for each point from a fit that did not see it: what a place between the touches may
  expect, and the more honest of the two. A feature with one touch has no such prediction and does not count here.

Root mean squares are over the touches but the z reference point, whose error is zero by definition.
[nist-diagnosis.md](nist-diagnosis.md) says what the diagnosis finds wrong with these parts.
`python -m scripts.nist_table --write` makes this page; a test compares it with what the code gives.
"""

TITLES: Final = ("Part", "Size, in", "Touches", "Semi-finish", "NIST's finish", "Predicted", "Left out")


@dataclass(frozen=True)
class Row:
    """RMS of one part or one feature of it, in µm."""

    name: str
    size_in: float
    touches: int
    semifinish_um: float
    nist_finish_um: float
    predicted_um: float
    left_out_um: float

    def __str__(self) -> str:
        numbers = (self.semifinish_um, self.nist_finish_um, self.predicted_um, self.left_out_um)
        cells = [self.name, f"{self.size_in:.2f}", str(self.touches), *(f"{number:.1f}" for number in numbers)]
        return f"| {' | '.join(cells)} |"


def corrected(part: NistPart) -> Correction:
    """The loop run on this part, with its job, programs and touches in files as a user has them."""
    with tempfile.TemporaryDirectory() as folder:
        return compensate(read_job(write_job(part, Path(folder))).inputs)


def write_job(part: NistPart, folder: Path) -> Path:
    """Writes a job with its programs and touches into a folder; the path of the job file."""
    for cut in ("finish", "semifinish"):
        (folder / f"{cut}.nc").write_text(program(part, cut), encoding="utf-8")
    (folder / "touches.csv").write_text(touches_csv(part.semifinish, "touches"), encoding="utf-8")
    example = (part.family.folder / "job.toml").read_text(encoding="utf-8")
    values = ", ".join(f"{name} = {value!r}" for name, value in parameters(part).items())
    rest = [
        f"parameters = {{ {values} }}" if line.startswith("parameters") else line
        for line in example[example.index("[tool]") :].splitlines()
    ]
    job = folder / "job.toml"
    job.write_text("\n".join([part_table_toml(part_name(part), part.profile), *rest, ""]), encoding="utf-8")
    return job


def part_name(part: NistPart) -> str:
    """As the tables head their columns: part and inspection after the semi-finish cut."""
    return f"{part.family.name} {part.number}.{part.semifinish_inspection}"


def whole_row(part: NistPart, correction: Correction) -> Row:
    """All touches but the z reference."""
    return _row(part, correction, ~correction.touches.at_reference)


def arc_row(part: NistPart, correction: Correction) -> Row | None:
    """The touches on the part's arc, if it has one."""
    arcs = [i for i, feature in enumerate(part.profile.features) if isinstance(feature, Arc)]
    return _row(part, correction, np.isin(correction.touches.feature_index, arcs)) if arcs else None


def page(results: Sequence[tuple[NistPart, Correction]]) -> str:
    """The whole page, from parts and their corrections."""
    arcs = [row for part, correction in results if (row := arc_row(part, correction)) is not None]
    whole = [whole_row(part, correction) for part, correction in results]
    tables = [("Whole parts", whole), ("The dome and the knob alone", arcs)]
    bands = section([(part_name(part), part, correction) for part, correction in results])
    return "\n".join([HEAD, *(f"## {title}\n\n{_table(rows)}\n" for title, rows in tables), bands])


def _row(part: NistPart, correction: Correction, chosen: NDArray[np.bool_]) -> Row:
    finish = np.array([touch.error_mm for touch in part.finish], dtype=np.float64)
    prediction = correction.prediction
    left_out = prediction.leave_one_out_mm[chosen]
    return Row(
        part_name(part),
        part.size_in,
        int(chosen.sum()),
        _rms_um(prediction.before_mm[chosen]),
        _rms_um(finish[chosen]),
        _rms_um(prediction.after_mm[chosen]),
        _rms_um(left_out[np.isfinite(left_out)]),
    )


def _rms_um(values_mm: Array) -> float:
    return rms(values_mm) * UM_PER_MM


def _table(rows: Iterable[Row]) -> str:
    rule = "|".join(["---", *["--:"] * (len(TITLES) - 1)])
    return "\n".join([f"| {' | '.join(TITLES)} |", f"|{rule}|", *map(str, rows)])


def main() -> None:
    """Prints the page, or writes it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/nist-parts.md and the examples' touches")
    written = page([(part, corrected(part)) for part in parts()])
    if not parser.parse_args().write:
        print(written)
        return
    for path, text in {PAGE: written, **example_touches()}.items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
