"""Time and memory of reading QIF documents of 1 GB: geometry, points, results. The table of docs/inspection-formats.md.

Usage: python -m scripts.large_qif [MEGABYTES]
"""

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from itertools import count
from pathlib import Path

BLOCK = 10_000
"""Pieces that are written at once."""
HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<QIFDocument xmlns="http://qifstandards.org/xsd/qif3" versionQIF="3.0.0" idMax="1">
<FileUnits><PrimaryUnits><LinearUnit><SIUnitName>meter</SIUnitName><UnitName>mm</UnitName></LinearUnit></PrimaryUnits></FileUnits>
"""
PLAN = """<Characteristics><CharacteristicDefinitions n="1"><DiameterCharacteristicDefinition id="1"><Tolerance>
<MaxValue>10.1</MaxValue><MinValue>9.9</MinValue><DefinedAsLimit>true</DefinedAsLimit></Tolerance>
</DiameterCharacteristicDefinition></CharacteristicDefinitions><CharacteristicNominals n="1">
<DiameterCharacteristicNominal id="2"><CharacteristicDefinitionId>1</CharacteristicDefinitionId>
<TargetValue>10</TargetValue></DiameterCharacteristicNominal></CharacteristicNominals><CharacteristicItems n="1">
<DiameterCharacteristicItem id="3"><Name>D1</Name><CharacteristicNominalId>2</CharacteristicNominalId>
</DiameterCharacteristicItem></CharacteristicItems></Characteristics>
<Results><MeasurementResultsSet n="1"><MeasurementResults id="4">
"""
TAIL = "</MeasurementResults></MeasurementResultsSet></Results></QIFDocument>\n"


def geometry(_: int) -> tuple[str, Iterator[str], str]:
    """Faces with attributes, as a drawn part has them; one result."""
    faces = (
        f'<Face id="{k}" label="F{k}"><LoopIds n="2"><Id>{k + 1}</Id><Id>{k + 2}</Id></LoopIds><Surface>'
        f"<Location>{k * 0.1:.3f} 2.5 {k * 0.2:.3f}</Location></Surface></Face>\n"
        for k in count(10)
    )
    close = f"</FaceSet></TopologySet></Product>\n{PLAN}{result_list(result(5))}{TAIL}"
    return f"{HEAD}<Product><TopologySet><FaceSet>", faces, close


def points(size: int) -> tuple[str, Iterator[str], str]:
    """One set of points."""
    lines = (f"{k % 997 * 0.1:08.4f} {k % 991 * 0.1:08.4f} {k % 983 * 0.01:08.4f}\n" for k in count())
    blocks = -(-size // (BLOCK * len("000.0000 000.0000 000.0000\n")))
    close = f"</Points><Compensated>true</Compensated></MeasuredPointSet></MeasuredPointSets>{TAIL}"
    opening = f'<MeasuredPointSets n="1"><MeasuredPointSet id="5" count="{blocks * BLOCK}"><Points>'
    return f"{HEAD}{PLAN}{opening}", lines, close


def results(_: int) -> tuple[str, Iterator[str], str]:
    """Diameters."""
    open_list, close_list = result_list("|").split("|")
    return f"{HEAD}{PLAN}{open_list}", (result(k) for k in count(5)), f"{close_list}{TAIL}"


def result(number: int) -> str:
    """One measured diameter."""
    return (
        f'<DiameterCharacteristicMeasurement id="{number}">\n<Status><CharacteristicStatusEnum>PASS'
        "</CharacteristicStatusEnum></Status>\n<CharacteristicItemId>3</CharacteristicItemId>\n"
        f"<Value>10.0{number % 90:02d}</Value>\n</DiameterCharacteristicMeasurement>\n"
    )


def result_list(members: str) -> str:
    """What stands around results."""
    return (
        f"<MeasuredCharacteristics><CharacteristicMeasurements>{members}</CharacteristicMeasurements>"
        "</MeasuredCharacteristics>"
    )


KINDS = {"faces and attributes": geometry, "points of one set": points, "results": results}


def write(path: Path, kind: str, size: int) -> None:
    """A document of about `size` bytes."""
    head, middle, tail = KINDS[kind](size)
    with path.open("w", encoding="utf-8", newline="\n") as file:
        written = file.write(head)
        while written < size:
            written += file.write("".join(next(middle) for _ in range(BLOCK)))
        file.write(tail)


def read(path: Path) -> None:
    """Reads it in this process and prints what it took."""
    from trueloop.formats.inspections.known import read_measured_file
    from trueloop.formats.inspections.measured_file import StatedFacts

    start = time.process_time()
    found = read_measured_file(path, StatedFacts())
    taken = time.process_time() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    held = sum(len(one.values) for one in found.inspections)
    print(f"{sum(one.count for one in found.inspections)} | {held} | {taken:.0f} | {peak:.0f} |")


def main() -> None:
    """Each kind in a process of its own."""
    size = int(sys.argv[1] if len(sys.argv) > 1 else "1000") * 1_000_000
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "large.qif"
        for kind in KINDS:
            write(path, kind, size)
            print(f"| {kind} | ", end="", flush=True)
            code = f"from pathlib import Path; from scripts.large_qif import read; read(Path({str(path)!r}))"
            subprocess.run([sys.executable, "-c", code], check=True)


if __name__ == "__main__":
    main()
