"""Every way in which a milled part's job, measurements and records are refused."""

import json
import tempfile
from collections.abc import Callable
from pathlib import Path

from trueloop.controllers.probing.inspection_plus import MacroProbe, inspection_plus_program
from trueloop.errors import Code
from trueloop.formats.examples import copy_example
from trueloop.jobs.milled import KIND, entries_for_next_part, read_milled
from trueloop.milled.feature import MilledFeature

MEASURED = '[[measured]]\nfile = "part-1.dmo"\n'


def _job(
    change: Callable[[str], str], record: object = None, program: Callable[[str], str] = lambda text: text
) -> object:
    folder = Path(tempfile.mkdtemp()) / "plate"
    copy_example("plate", folder)
    path = folder / "plate.toml"
    path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")
    finish = folder / "finish.nc"
    finish.write_text(program(finish.read_text(encoding="utf-8")), encoding="utf-8")
    (folder / "entries.json").write_text(json.dumps(record), encoding="utf-8")
    return entries_for_next_part(read_milled(path))


def _second(entered: str) -> Callable[[str], str]:
    return lambda text: text + "\n" + MEASURED + entered


def _from_two_offsets(text: str) -> str:
    bores = text[text.index("T2 M6") : text.index("G42")]
    return text.replace("M30", bores.replace("G54", "G55") + "G40\nM30")


FACED = "G0 X-90. Y95.\nG1 Z-15.02 F200.\nX90.\nG0 Z50.\n"
CORNER = "G0 X-90. Y-90.\nG1 Z-5. F200.\nG41 D21 X-80.\nG3 X-70. Y-80. I0. J10.\nG40 G1 X-90.\nG0 Z50.\n"
BORE = MilledFeature("B", "bore", (0.0, 0.0, 0.0), 1, "G54", 12.0, depth_mm=10.0)
OTHER = {"kind": KIND, "part_type": "cover", "before": {}, "entries": []}
SHIFTED = {
    "kind": KIND,
    "part_type": "plate",
    "before": {},
    "entries": [{"register": "x", "of": "G54", "change": 0.03, "unit": "mm"}],
}

PRODUCERS = {
    Code.MIL_NOMINAL: lambda: _job(lambda text: text + '\n[names]\nB0 = "B1"\n'),
    Code.MIL_NONE: lambda: _job(lambda text: text.replace('name = "', 'name = "my ')),
    Code.MIL_LARGE: lambda: _job(lambda text: text + "\n[limits]\ndeviation_um = 30\n"),
    Code.MIL_ENTRY: lambda: _job(lambda text: text + "\n[limits]\nentry_um = 15\n"),
    Code.MIL_ENTERED: lambda: _job(_second("")),
    Code.MIL_CONTRADICTED: lambda: _job(_second('entered = ["entries.json"]\n'), SHIFTED),
    Code.MIL_CUT: lambda: _job(str, program=_from_two_offsets),
    Code.MIL_NOT_CUT: lambda: _job(lambda text: text.replace("at = [-50.0, -30.0", "at = [-50.0, -31.0")),
    Code.MIL_SIDE: lambda: _job(lambda text: text.replace('kind = "boss"', 'kind = "bore"')),
    Code.MIL_STATED: lambda: _job(lambda text: text.replace('name = "B0"', 'name = "B0"\ntool = 1')),
    Code.MIL_SET: lambda: _job(str, program=lambda text: text.replace("T2 M6", "G10 L2 P1 X-300. Y-200.\nT2 M6")),
    Code.MIL_LEVELS: lambda: _job(str, program=lambda text: text.replace("T2 M6", FACED + "T2 M6")),
    Code.MIL_REGISTER: lambda: _job(str, program=lambda text: text.replace("D22", "D21")),
    Code.MIL_CORNER: lambda: _job(str, program=lambda text: text.replace("T2 M6", CORNER + "T2 M6")),
    Code.MIL_DEVICE: lambda: _job(
        lambda text: text + '\n[[device]]\nname = "probe"\nring = 25\nring_measured = 24.9\n'
    ),
    Code.MIL_PROBE: lambda: inspection_plus_program("p", [BORE], MacroProbe(30, 6.0, 2.0)),
    Code.MIL_RECORD: lambda: _job(_second('entered = ["entries.json"]\n'), OTHER),
}
