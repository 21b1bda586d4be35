"""Makes docs/errors.md, the page of all error codes, from the catalogue."""

from itertools import groupby
from typing import Final

from trueloop.errors import Code

AREAS: Final = {
    "GEO": "Nominal profiles and drawings",
    "NC": "NC programs",
    "TCH": "Touches",
    "MSR": "Inspection files of gauges, measuring machines and controls",
    "OFS": "Tool offsets and the tool tables of controls",
    "PRB": "Probing: plans, programs, logs",
    "FIT": "Error curves",
    "CMP": "Corrections and their limits",
    "TOL": "tolerances and characteristics",
    "SRF": "Surfaces",
    "MIL": "Milled parts",
    "MCH": "Machine models",
    "REC": "Records of corrections",
    "SIM": "The simulator",
    "DIA": "causes of errors",
    "MON": "charts and capability",
    "CTL": "Controls",
    "LNK": "Links to controls",
    "MTC": "MTConnect",
    "FAC": "The factory: orders, runs, decisions",
    "CEL": "The cell beside a control",
    "SRV": "The service",
    "RTC": "Real-time correction",
    "JOB": "Job files",
    "SET": "Set-ups of one part",
    "STO": "the store of parts, tools, inspections and corrections",
    "LAB": "labels of parts and programs",
    "EDG": "cutting edges and their events",
    "MEM": "what is remembered",
    "SER": "series of parts",
    "VAL": "Stored values",
    "OUT": "Outputs",
}
HEAD: Final = """# Errors

A message names its code, what was wrong with values and units, where (file, line, column) and a hint. With `--json` it
is an object with the same parts, and with `values`: what the third column names, as numbers and texts, so that no
program has to read the message. A name ends with its unit; x is a radius, and `unit` is the unit of values whose name
has none. Where the column is empty, the errors of that code have no values in common. [cli.md](cli.md) has the exit
statuses. The letters of a code name its area.
"""


def page() -> str:
    """Returns the page: a table an area, in the catalogue's order."""
    parts = [HEAD]
    for area, codes in groupby(Code, key=lambda code: code.split("-")[0]):
        rows = "".join(f"| `{code}` | {code.meaning} | {_names(code)} |\n" for code in codes)
        parts.append(f"\n## {area}: {AREAS[area]}\n\n| code | it is about | values |\n|---|---|---|\n{rows}")
    return "".join(parts)


def _names(code: Code) -> str:
    return ", ".join(f"`{name}`" for name in code.values)
