"""The kinds of TOML files that trueloop reads, by the word that a page of the manual has for them."""

import tomllib
from typing import Final

from pydantic import ValidationError

from trueloop.formats import cell_toml, links_toml
from trueloop.formats.inspections.controls import meaning
from trueloop.formats.inspections.tables import mapping
from trueloop.formats.jobs import job, machine_toml, milled_job, probe_toml, surface_job
from trueloop.formats.measurements import instruments_toml
from trueloop.formats.realtime import signals_toml
from trueloop.formats.tables import offsets_toml
from trueloop.formats.toml_tables import Table
from trueloop_lab.files import virtual_machine_toml
from trueloop_lab.files.virtual_machine_toml import VirtualMillFile

KINDS: Final[dict[str, type[Table]]] = {
    "job": job.Job,
    "probe": probe_toml.ProbeFile,
    "surface": surface_job.SurfaceJobFile,
    "milled": milled_job.MilledJobFile,
    "machine": machine_toml.MachineFile,
    "virtual-machine": virtual_machine_toml.VirtualMachineFile,
    "virtual-mill": VirtualMillFile,
    "readings": instruments_toml.ReadingsFile,
    "offsets": offsets_toml.OffsetsFile,
    "mapping": mapping.Mapping,
    "meaning": meaning.Meaning,
    "signals": signals_toml.SignalsFile,
    "links": links_toml.LinksFile,
    "cell": cell_toml.CellFile,
}


def wrong_in(text: str, kind: str) -> list[str]:
    """What is wrong in a piece of such a file: all but that keys are missing, which a piece may leave out."""
    try:
        KINDS[kind].model_validate(tomllib.loads(text))
    except ValidationError as refused:
        return [
            f"{one['loc']}: {one['msg']}"
            for one in refused.errors()
            if one["type"] != "missing" and not isinstance(one["input"], dict)  # what a whole table asks for
        ]
    return []
