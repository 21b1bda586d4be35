"""A hint that is followed leads on: the same complaint does not come back."""

from pathlib import Path

import pytest

import trueloop
from scripts.key_tables import TABLES
from tests.support.cli import output_of
from tests.support.gauged import EXAMPLES, shaft_with
from trueloop.errors import Code, TrueloopError

READINGS = (EXAMPLES / "shaft" / "readings.csv").read_text(encoding="utf-8")
NO_KEY = "is no key of this file"
OF_TABLES = [
    (heading, key)
    for heading, model in TABLES["job-file.md"].items()
    for key in model.model_fields
    if heading.startswith("[") and "." not in heading and not heading.startswith("[[") and len(key) > 4
]


def _said(folder: Path, heading: str, line: str) -> str:
    """What `trueloop compensate` says of the example with one more line in a table, which must be refused."""
    job = shaft_with(folder, READINGS)
    text = job.read_text(encoding="utf-8")
    if f"{heading}\n" not in text:
        text += f"\n{heading}\n"
    job.write_text(text.replace(f"{heading}\n", f"{heading}\n{line}\n", 1), encoding="utf-8")
    return output_of("compensate", job, "--no-store", "-o", folder / "out", status=3)


@pytest.mark.parametrize(("heading", "key"), OF_TABLES)
def test_a_misspelt_key_of_a_job_is_named_as_it_is_meant_and_the_name_is_taken(
    tmp_path: Path, heading: str, key: str
) -> None:
    misspelt = key[:2] + key[3:]
    said = _said(tmp_path / "wrong", heading, f"{misspelt} = []")
    assert NO_KEY in said and f"did you mean '{key}'?" in said, said
    assert NO_KEY not in _said(tmp_path / "followed", heading, f"{key} = [[[]]]")


def test_a_part_measured_before_the_correction_that_is_stated_to_have_cut_it(tmp_path: Path) -> None:
    """MSR-OLD: leave out `gauging.after_record`, and state `programs.cut_with`."""
    record = (
        '{"id": "0", "product": "turned", "inputs_sha256": {}, "made_at": "2026-11-21T08:00:00+01:00", '
        '"made_by": "", "options": {}, '
        '"trueloop_version": "1", "model": {"curves": []}, "decision": [], "changes": [], "components": []}'
    )
    job = shaft_with(tmp_path, READINGS, 'after_record = "record.json"\n')
    (tmp_path / "record.json").write_text(record)
    call = ("compensate", job, "--no-store", "-o", tmp_path / "out")
    assert "MSR-OLD" in output_of(*call, status=3)
    text = job.read_text(encoding="utf-8").replace('after_record = "record.json"\n', "")
    job.write_text(text.replace("[programs]\n", '[programs]\ncut_with = "given"\n'), encoding="utf-8")
    output_of(*call)
    assert (tmp_path / "out" / "corrected.nc").is_file()


def test_a_table_of_a_job_without_its_unit(tmp_path: Path) -> None:
    """MSR-UNIT: the hint of a job names its key, `--unit` of `compensate` is that of the report."""
    table = "characteristic;nominal;upper;lower;value\nDIA 44;44.0;0.05;-0.05;44.020\nDIA 36;36.0;0.05;-0.05;36.020\n"
    job = shaft_with(tmp_path, table)
    call = ("compensate", job, "--no-store", "-o", tmp_path / "out")
    refused = output_of(*call, status=3)
    assert "MSR-UNIT" in refused and 'gauging.readings_unit = "mm" or "inch"' in refused and "--unit" not in refused
    text = job.read_text(encoding="utf-8")
    job.write_text(text.replace("[gauging]\n", '[gauging]\nreadings_unit = "mm"\n'), encoding="utf-8")
    output_of(*call)
    assert (tmp_path / "out" / "record.json").is_file()


@pytest.mark.parametrize(
    ("column", "meant"),
    [
        *(("reding_um", "reading_um"), ("reading_urads", "reading_urad"), ("reading_arcsecs", "reading_arcsec")),
        *(("x_mm", "X_mm"), ("X_mmm", "X_mm"), ("absolut", "absolute"), ("alog", "along")),
    ],
)
def test_a_misspelt_column_is_named_as_it_is_meant_and_the_name_is_taken(
    tmp_path: Path, column: str, meant: str
) -> None:
    assert f"did you mean '{meant}'?" in _hint_for_columns(tmp_path, column)
    assert "is not one of" not in _hint_for_columns(tmp_path, meant)


OTHER_UNITS = (
    *("reading_nm", "reading_m", "reading_rad", "reading_mrad", "reading_deg", "reading_mil", "reading_microns"),
    *("X_m", "X_cm", "X_um", "T1_C", "T1_celsius", "u_nm", "u_rad"),
)


@pytest.mark.parametrize("column", OTHER_UNITS)
def test_a_column_in_another_unit_is_to_be_converted_not_renamed(tmp_path: Path, column: str) -> None:
    said = _hint_for_columns(tmp_path, column)
    assert "did you mean" not in said and "convert it" in said and "_degC" in said, said


def _hint_for_columns(folder: Path, column: str) -> str:
    """What is said of the example's readings with a column named otherwise; the hint of the refusal among it."""
    text = Path(trueloop.example("machine/readings.csv")).read_text(encoding="utf-8")
    header, _, rows = text.partition("\n")
    names = header.split(",")
    kinds = {"r": "reading_um", "x": "X_mm", "X": "X_mm", "T": "T1_degC", "u": "u_um", "al": "along", "ab": "absolute"}
    old = kinds.get(column[:2], kinds.get(column[0], ""))
    names[names.index(old)] = column
    (folder / "readings.csv").write_text(",".join(names) + "\n" + rows, encoding="utf-8")
    machine, _ = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    try:
        trueloop.read_readings(folder / "readings.csv", machine.chain)
    except TrueloopError as refused:
        assert refused.code in (Code.MCH_FILE, Code.MCH_UNIT)
        return str(refused)
    return ""
