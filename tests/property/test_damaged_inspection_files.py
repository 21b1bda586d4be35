"""Whatever happens to a file on its way, each reader of inspection files gives inspections or a refusal."""

import shutil
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.qdas import HEAD, value_line
from tests.support.qdas import characteristic as field_of
from tests.support.qif import characteristic, document, measured, results
from trueloop.errors import TrueloopError
from trueloop.formats.inspections.known import KNOWN, read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts

POINTS = (
    '<MeasuredFeatures><PointFeatureMeasurement id="60"><FeatureItemId>51</FeatureItemId><Location>9 9 9</Location>'
    '</PointFeatureMeasurement></MeasuredFeatures><MeasuredPointSets><MeasuredPointSet id="70" count="1"><Points>1 2 3'
    "</Points><Compensated>false</Compensated><ProbeRadius>2</ProbeRadius></MeasuredPointSet></MeasuredPointSets>"
)
DMIS = """FILNAM/'part',5.3
UNITS/MM,ANGDEC
F(H1)=FEAT/CIRCLE,INNER,CART,10,20,0,0,0,1,8
FA(H1)=FEAT/CIRCLE,CART,10.01,20.00,0,0,0,1,$$
8.012
T(H1_D)=TOL/DIAM,-0.05,0.05
TA(H1_D)=TOL/DIAM,0.012,INTOL
"""
PC_DMIS = """DIM L1= LOCATION OF CIRCLE C1  UNITS=MM
AX  NOMINAL  +TOL  -TOL   MEAS    DEV  OUTTOL
X    20.000 0.050 0.050 20.007  0.007   0.000
D    10.000 0.050 0.050 10.013  0.013   0.000
"""
PRINT = """   COMPONENT NO 4                    FEATURE NO 1
SIZE D30.0000   ACTUAL 30.0232   TOL 0.0200   DEV 0.0232
"""
FILES = {
    "part.qif": document(
        results(measured("3", "10.02"), measured("13", "30", "Angle"), before=POINTS),
        characteristics=[characteristic(1), characteristic(11, "Angle", "30", "", "A1")],
    ),
    "part.dfq": HEAD + field_of(1) + field_of(2, "Winkel", "30", ("29", "31"), "°") + value_line(("10.02", "0"), "30"),
    "part.dmo": DMIS,
    "part.txt": PC_DMIS,
    "print.txt": PRINT,
    "macro.txt": "#500=29.991\n#501=[25283*65536+65536]/134217728\n#502=\n",
    "log.txt": "1 2 3 0 0 0 0 0 0\n4 5 6 0 0 0 0 0 0\n",
    "part_chr.txt": "id\tactual\tnominal\tuppertol\tlowertol\tdeviation\nD1\t10.01\t10\t0.1\t-0.1\t0.01\nEND\n",
    "part.csv": "name;nominal [mm];upper limit [mm];lower limit [mm];actual [mm]\nD1;25;25,1;24,9;25,02\n",
    "gauge.txt": "01A+00012.345\r\n01A+00012.346\r\n",
}
"""Sound files of the formats that are read."""
PIECES = st.one_of(
    st.binary(max_size=12),
    st.sampled_from([b"", b"\0", b"\xff\xfe", b"1e999", b"nan", b"-", b",", b"/", b"\n", b"\x14", b"(", b'"']),
    st.sampled_from(
        [b"<!DOCTYPE a>", b"&lt;", b"]]>", b"99999999999999999999", b"31.02.2024", b"\xb0", b"\xe2\x8c\x80"]
    ),
)
DAMAGE = st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(0, 40), PIECES), min_size=1, max_size=4)


def _damaged(content: bytes, damage: list[tuple[float, int, bytes]]) -> bytes:
    """Pieces of a file replaced by others: where (as a part of its length), how many bytes, by what."""
    for where, length, piece in damage:
        start = int(where * len(content))
        content = content[:start] + piece + content[start + length :]
    return content


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("damaged")


def _read(folder: Path, name: str, content: bytes) -> MeasuredFile | TrueloopError:
    path = folder / name
    path.write_bytes(content)
    try:
        return read_measured_file(path, StatedFacts("mm"))
    except TrueloopError as error:
        assert str(error.code) in str(error) and error.place is not None
        return error


@pytest.mark.parametrize("name", FILES)
@settings(max_examples=30)
@given(damage=DAMAGE)
def test_a_damaged_file_is_read_or_refused(folder: Path, name: str, damage: list[tuple[float, int, bytes]]) -> None:
    _read(folder, name, _damaged(FILES[name].encode(), damage))


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "cp1252", "gb18030"])
def test_so_is_one_in_another_encoding_and_one_cut_short(folder: Path, name: str, encoding: str) -> None:
    content = FILES[name].encode(encoding)
    for length in (0, 1, 7, len(content) // 2, len(content) - 1, len(content)):
        _read(folder, name, content[:length])


def test_the_sound_files_are_those_of_many_formats(folder: Path) -> None:
    """Else the tests above would prove little."""
    shutil.rmtree(folder)
    folder.mkdir()
    read = {name: _read(folder, name, text.encode()) for name, text in FILES.items()}
    formats = {one.format.split()[0] for one in read.values() if isinstance(one, MeasuredFile)}
    assert len(formats) >= min(6, len(KNOWN)), {name: str(one)[:200] for name, one in read.items()}
