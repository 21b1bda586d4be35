"""Any text in a file gives a value or a refusal: what a user's file does must not look like a fault of trueloop."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.machines import chain_with_travel
from tests.support.places import EXAMPLES
from trueloop.errors import TrueloopError
from trueloop.formats.cad.dxf import read_dxf
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.jobs.machine_toml import read_machine
from trueloop.formats.jobs.probe_toml import read_probe
from trueloop.formats.jobs.surface_job import read_surface_job
from trueloop.formats.measurements.field_csv import read_field
from trueloop.formats.measurements.history_csv import read_drift, read_history
from trueloop.formats.measurements.inspections_csv import read_inspections
from trueloop.formats.measurements.positioning_data import read_plate_report, read_positioning
from trueloop.formats.measurements.readings_csv import read_readings
from trueloop.formats.measurements.surface_csv import read_points
from trueloop.formats.measurements.touches_csv import read_probe_log, read_touches
from trueloop.formats.tables.model_file import read_model
from trueloop_lab.files.virtual_machine_toml import read_virtual_machine, read_virtual_mill


def _example(name: str) -> str:
    return (EXAMPLES / name).read_text(encoding="utf-8")


GANTRY = chain_with_travel("mill-gantry")
PLACES = ",".join(f"{kind}_{c}_mm" for kind in ("nominal", "controller", "cmm") for c in "xyz")
MODEL = """{"format": "trueloop machine model 2",
"machine": {"name": "M", "serial": "", "work": [], "tool": [
{"name": "X", "kind": "linear", "number": 1, "offset_mm": [0, 0, 0], "travel": [0, 500]}]},
"identified": {"X": [0, 500]}, "lags": [{"name": "L", "of": "T1", "constant_s": 60, "power": 1, "between_s": [1, 2]}],
"terms": [{"error": "EXX", "both_ways": false, "parts": [
{"breaks": [0, 500], "degree": 1, "zero_at": [0], "signal": null, "reference": 0}]}],
"coefficients": [0, 0.1], "covariance": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}"""
MACHINE = """[machine]
name = "M"
structure = "mill-gantry"
[axes.X]
travel_mm = [0, 500]
[axes.Y]
travel_mm = [0, 400]
[axes.Z]
travel_mm = [-300, 0]
[terms]
standard = "mill"
[[term]]
error = "EXX"
signals = { T1 = 20.0 }
[lags.T2]
of = "T1"
constant_s = [60, 600]
"""
DXF = "".join(
    f"{line}\n"
    for line in (
        *("0", "SECTION", "2", "HEADER", "9", "$INSUNITS", "70", "4", "0", "ENDSEC"),
        *("0", "SECTION", "2", "ENTITIES", "0", "LINE", "8", "0", "10", "0", "20", "30", "11", "10", "21", "30"),
        *("0", "ARC", "8", "0", "10", "10", "20", "20", "40", "10", "50", "0", "51", "90", "0", "ENDSEC", "0", "EOF"),
    )
)

READERS: dict[str, tuple[Callable[[Path], object], str]] = {
    "touches": (read_touches, "point,feature,nominal_x_mm,nominal_z_mm,error_um\n1,dome,40,5,3\n2,dome,40,6,4\n"),
    "readings": (
        lambda path: read_readings(path, GANTRY),
        "X_mm,travel_X,along_x,along_y,along_z,reading_um,u_um,time_s,T1_degC\n0,+,1,0,0,1,1,0,20\n1,-,0,1,0,2,1,9,21\n",
    ),
    "history": (read_history, "time_s,T1_degC,S_rpm\n0,20,0\n60,21,900\n"),
    "drift": (read_drift, "time_s,T1_degC,EX_um\n0,20,0\n60,21,1\n"),
    "inspections": (
        read_inspections,
        f"# touch_u_um 0.5\n{PLACES},normal_x,normal_y,normal_z\n1,2,3,1,2,3,1,2,3,0,0,1\n",
    ),
    "positioning": (
        read_positioning,
        "target_mm,approach,cycle,actual_mm\n0,up,1,0\n0,down,1,0\n0,up,2,0\n0,down,2,0\n"
        "9,up,1,9\n9,down,1,9\n9,up,2,9\n9,down,2,9\n",
    ),
    "assignments": (
        read_positioning,
        "UNIT=mm\n"
        + "".join(f"TGT_DATA[{k}]={k}\n" for k in (1, 2))
        + "".join(f"REF_DATA_{way}[{k},{n}]={k}.1\n" for way in ("FWD", "BWD") for k in (1, 2) for n in (1, 2)),
    ),
    "points": (read_points, "row,column,x_mm,y_mm,z_mm\n1,1,0,0,0\n1,2,1,0,0\n2,1,0,1,0\n"),
    "field": (read_field, "x_mm,y_mm,dx_um\n0,0,1\n10,0,2\n0,5,1\n10,5,2\n"),
    "log": (lambda path: read_probe_log(path, "linuxcnc"), "1 2 3 4 5 6 7 8 9\n"),
    "DPRNT": (lambda path: read_probe_log(path, "fanuc"), "X12.000 Z-91.200\n"),
    "plates": (read_plate_report, "report\n1 2 1 2 0 0 5 5 0.01\n"),
    "job": (read_turned_job, _example("modbas2/job.toml")),
    "surface job": (read_surface_job, _example("surface/surface.toml")),
    "machine": (read_machine, MACHINE),
    "model": (read_model, MODEL),
    "virtual machine": (read_virtual_machine, _example("loop/machine.toml")),
    "probe": (read_probe, _example("loop/probe.toml")),
    "virtual mill": (read_virtual_mill, _example("surface/mill.toml")),
    "drawing": (read_dxf, DXF),
}

NUMBERS = (
    "nan",
    "inf",
    "-1",
    "0",
    "1e308",
    "1e15",
    "-1e15",
    "9" * 400,
    "1e-320",
    "0001-01-01T00:00:00",
    "true",
    "null",
)
ODD = ('"', "'", "\n", "\0", "\r", ";", "\t", ",", "#", "[", "]", "[" * 3000, "{", "=", "\ufeff", "%", "Ω", "\x85")


def _changed(draw: st.DrawFn, text: str) -> str:
    """Pieces cut out, doubled, replaced by odd ones, or numbers by ones that no machine has."""
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(text)))
        end = draw(st.integers(at, min(at + 12, len(text))))
        piece = draw(st.sampled_from((*NUMBERS, *ODD, "", text[at:end] * 2)) | st.text(max_size=5))
        text = text[:at] + piece + text[end:]
    return text


@st.composite
def _texts(draw: st.DrawFn, good: str) -> str:
    """A good file with damage, with one of its words replaced, or any text at all."""
    if draw(st.booleans()):
        words = [k for k, mark in enumerate(good) if mark.isdigit() and (k == 0 or not good[k - 1].isalnum())]
        at = draw(st.sampled_from(words))
        end = next((k for k in range(at, len(good)) if good[k] not in "0123456789.-e"), len(good))
        return good[:at] + draw(st.sampled_from(NUMBERS)) + good[end:]
    return _changed(draw, good) if draw(st.integers(0, 9)) else draw(st.text(max_size=100))


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("any") / "file"


@pytest.mark.parametrize("name", READERS)
def test_the_files_are_good_as_they_stand(path: Path, name: str) -> None:
    read, good = READERS[name]
    path.write_text(good, encoding="utf-8")
    read(path)


@pytest.mark.parametrize("name", READERS)
@given(data=st.data())
def test_any_text_gives_a_value_or_a_refusal_that_names_the_file(path: Path, name: str, data: st.DataObject) -> None:
    read, good = READERS[name]
    path.write_bytes(data.draw(_texts(good)).encode("utf-8", "replace"))
    try:
        read(path)
    except TrueloopError as refusal:
        assert refusal.place.file == str(path)
        assert refusal.message and refusal.hint
