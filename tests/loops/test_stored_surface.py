"""Corrections of surfaces and programs are data too: from a pickle and from JSON they come back and write the same."""

import pickle
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from trueloop.domain.option import MapOptions
from trueloop.domain.record import Correction
from trueloop.formats.outputs import Named
from trueloop.formats.record_file import read_record
from trueloop.jobs.machine.mapped_program import displace_program
from trueloop.jobs.surface.job import corrected_files, read_surface
from trueloop.loops.machine import program as machine
from trueloop.loops.surface import correction as surface
from trueloop.loops.surface.correction import correct_parts
from trueloop.nc.field import similarity_field

EXAMPLES = Path(__file__).parents[2] / "examples"


def without_cad(files: Sequence[Named], notes: list[str]) -> tuple[Sequence[Named], list[str]]:
    """The CAD kernel counts and dates what it writes: its files differ each time."""
    return [one for one in files if Path(one[0]).suffix not in (".step", ".igs")], notes


def test_a_surface_s_correction_comes_back_and_writes_the_same_files() -> None:
    read = read_surface(EXAMPLES / "surface" / "surface.toml")
    inputs = replace(read.inputs, parts=read.inputs.parts[:3])
    done = correct_parts(inputs, datetime(2026, 11, 23, tzinfo=UTC))
    envelope = surface.enveloped(done)
    copies = (
        surface.CODEC.from_json(surface.CODEC.to_json(envelope), Correction),
        pickle.loads(pickle.dumps(envelope)),
    )
    for copy in copies:
        assert copy == envelope and copy.payload is not envelope.payload
        again = replace(done, correction=copy.payload, record=copy.record)
        assert without_cad(*corrected_files(read, again)) == without_cad(*corrected_files(read, done))
    assert envelope.source_sha256 and envelope.limits["correction_mm"] == inputs.options.limits.correction_mm


def test_a_displaced_program_s_correction_comes_back(tmp_path: Path) -> None:
    options, target = MapOptions(limit_mm=0.05), tmp_path / "mapped.ngc"
    field = similarity_field(shift_mm=(0.0, 0.0, -0.02))
    done = displace_program(EXAMPLES / "surface" / "finish.ngc", target, field, options)
    envelope = Correction(
        read_record(tmp_path / "mapped.record.json"), {"limit_mm": options.limit_mm, "slope": options.slope}, done
    )
    assert machine.CODEC.from_json(machine.CODEC.to_json(envelope), Correction) == envelope
    assert pickle.loads(pickle.dumps(envelope)) == envelope
    assert envelope.identity == (done.record,) and envelope.source_sha256 == done.source_sha256
    assert envelope.limits == {"limit_mm": 0.05, "slope": options.slope}
