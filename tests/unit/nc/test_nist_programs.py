"""The programs of NISTIR 6811, Appendix A, scanning damage and all: read, run, checked."""

from pathlib import Path

import numpy as np
import pytest

from trueloop.errors import Code
from trueloop.nc.check.check import arc_misfit_mm, check
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.program.program import Program, read_program

pytestmark = pytest.mark.corpus

DAMAGED = {
    "030011": {Code.NC_DUPLICATE, Code.NC_MISPLACED},
    "030021": {Code.NC_DUPLICATE},
    "350021": {Code.NC_MISPLACED},
    "360021": {Code.NC_ARC},
    "370021": {Code.NC_NUMBER},
    "380021": {Code.NC_MISPLACED},
    "390021": {Code.NC_MISPLACED},
}
"""What the scanning did: a block's words in the comment of the line before, so that blocks run together or stay empty;
commas for points."""
ROUNDING_IN = 1e-5


def programs(corpus: Path) -> list[Program]:
    files = sorted((corpus / "data" / "nist" / "programs").glob("*.nc"))
    return [read_program(file.read_bytes(), "ge2000t", file.name) for file in files]


def parameters(program: Program) -> dict[str, float]:
    """P46 is the large diameter of FACETST (0600xx) and the main cylinder of MODBAS2 (0300xx)."""
    others = dict.fromkeys(("P44", "P45", "P47", "P48"), 0.0)
    return {"P41": 20.0, "P42": 20.0, "P46": 5.62 if (program.file or "").startswith("06") else 3.52, **others}


def test_all_eighteen_are_read_run_and_written_back(corpus: Path) -> None:
    found = programs(corpus)
    assert len(found) == 18
    for program in found:
        assert apply_edits(program, []) == program.source
        assert set(program.parameters_used()) <= set(parameters(program))
        path = program.run(parameters(program))
        assert len(path) > 10
        assert np.isfinite(path.end_mm).all()


def test_only_scanning_damage_is_remarked_upon(corpus: Path) -> None:
    for program in programs(corpus):
        codes = {finding.code for finding in check(program, parameters(program))}
        assert codes == DAMAGED.get((program.file or "").removesuffix(".nc"), set()), program.file


def test_arcs_fit_to_the_rounding_of_their_coordinates(corpus: Path) -> None:
    for program in programs(corpus):
        misfit_mm = arc_misfit_mm(program.run(parameters(program)))
        assert np.nanmax(np.abs(misfit_mm), initial=0.0) < ROUNDING_IN * 25.4, program.file


def test_linuxcnc_lathe_samples_have_no_rapid_move_through_material(corpus: Path) -> None:
    files = sorted((corpus / "data" / "public" / "nc").glob("linuxcnc-lathe-*.ngc"))
    assert len(files) == 2
    for file in files:
        findings = check(read_program(file.read_bytes(), "linuxcnc", file.name))
        assert {finding.code for finding in findings} <= {Code.NC_OPAQUE, Code.NC_TANGENT, Code.NC_BLEND}
