"""Writes the tables of keys into the pages that explain TOML files: `python -m scripts.key_tables`. Makes JSON schemas.

A page has a heading for each table of a file, and below it the table of its keys.
"""

import json
import re
from collections.abc import Collection
from enum import Enum
from pathlib import Path
from typing import Any, Final, Literal

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from trueloop.described import meanings
from trueloop.domain.option import unit_of
from trueloop.formats import cell_toml
from trueloop.formats.jobs import job, milled_job, part_tables, probe_toml, surface_job, tool_tables
from trueloop.formats.toml_tables import In
from trueloop.report.diagnosis.machine_shapes import MachineDiagnosisShape
from trueloop.report.diagnosis.shapes import FixtureDiagnosisShape, PartDiagnosisShape, SeriesDiagnosisShape
from trueloop.report.series.values import SeriesShape
from trueloop.report.shape import Shape
from trueloop.report.turned.shapes import CorrectionShape

DOCS: Final = Path(__file__).parents[1] / "docs"
TABLES: Final[dict[str, dict[str, type[BaseModel]]]] = {
    "job-file.md": {
        "[part]": part_tables.PartTable,
        "[[part.feature]]": part_tables.FeatureTable,
        "[part.feature.asphere]": part_tables.AsphereTable,
        "[part.feature.ellipse]": part_tables.EllipseTable,
        "[part.feature.polynomial]": part_tables.PolynomialTable,
        "[part.feature.spline]": part_tables.SplineTable,
        "[part.feature.points]": part_tables.PointsTable,
        "[[part.characteristic]]": part_tables.CharacteristicTable,
        "[tool]": tool_tables.ToolTable,
        "[[tools]]": tool_tables.ToolsTable,
        "[feature.NAME]": tool_tables.CutByTable,
        "[[setups]]": tool_tables.SetupTable,
        "[programs]": tool_tables.ProgramsTable,
        "[gauging]": job.GaugingTable,
        "[compensation]": job.CompensationTable,
        "[compensation.features.NAME]": job.FeatureFitTable,
        "[machine]": job.MachineTable,
        "[output]": job.OutputTable,
        "[report]": job.ReportTable,
        "[store]": job.StoreTable,
        "[memory]": job.MemoryTable,
    },
    "probing.md": {
        "[stylus]": probe_toml.StylusTable,
        "[approach]": probe_toml.ApproachTable,
        "[program]": probe_toml.ProgramTable,
        "[probe]": probe_toml.ProbeTable,
        "[calibration]": probe_toml.CalibrationTable,
    },
    "cell.md": {
        "[cell]": cell_toml.CellTable,
        "[linuxcnc]": cell_toml.LinuxcncTable,
        "[temperatures]": cell_toml.TemperaturesTable,
    },
    "surface.md": {
        "[surface]": surface_job.SurfaceTable,
        "[gauging]": surface_job.SurfaceGaugingTable,
        "[model]": surface_job.ModelTable,
        "[program]": surface_job.SurfaceProgramTable,
        "[cutter]": surface_job.CutterTable,
        "[compensation]": surface_job.SurfaceCompensationTable,
        "[output]": surface_job.SurfaceOutputTable,
        "[store]": job.StoreTable,
    },
    "milled.md": {
        "[[feature]]": milled_job.MilledFeatureTable,
        "[program]": milled_job.MilledProgramTable,
        "[[tool]]": milled_job.MillToolTable,
        "[[measured]]": milled_job.MeasuredTable,
        "[[device]]": milled_job.DeviceTable,
        "[frame]": milled_job.FrameTable,
        "[limits]": milled_job.MilledLimits,
        "[output]": milled_job.MilledOutput,
    },
}
"""By page and heading."""
SCHEMAS: Final[dict[str, type[BaseModel]]] = {
    "job.schema.json": job.Job,
    "probe.schema.json": probe_toml.ProbeFile,
    "surface.schema.json": surface_job.SurfaceJobFile,
    "milled.schema.json": milled_job.MilledJobFile,
    "correction.schema.json": CorrectionShape,
    "series.schema.json": SeriesShape,
    "diagnosis-part.schema.json": PartDiagnosisShape,
    "diagnosis-series.schema.json": SeriesDiagnosisShape,
    "diagnosis-fixture.schema.json": FixtureDiagnosisShape,
    "diagnosis-machine.schema.json": MachineDiagnosisShape,
}
HEAD: Final = "| Key | Unit | Default | Meaning |\n|---|---|---|---|\n"


def page(name: str) -> str:
    """A page of the documentation with its tables of keys as the code has them."""
    text = (DOCS / name).read_text(encoding="utf-8")
    for heading, model in TABLES[name].items():
        section = re.search(rf"#+ `{re.escape(heading)}`\n(?:(?!#|\|).*\n)*((?:\|.*\n)+)", text)
        if section is None:
            raise ValueError(f"{name}: no heading `{heading}` with a table below it")
        wider = [other for other in TABLES[name].values() if other is not model and issubclass(model, other)]
        above = {row(other, key) for other in wider for key in other.model_fields}
        text = text[: section.start(1)] + key_table(model, above) + text[section.end(1) :]
    return text


def key_table(model: type[BaseModel], above: Collection[str] = ()) -> str:
    """Returns key, unit, default and meaning of every key as a table in Markdown, without the rows that stand above."""
    rows = (row(model, key) for key in model.model_fields)
    return HEAD + "".join(line for line in rows if line not in above)


def schema(name: str) -> str:
    """A JSON schema, by which editors complete and check a file."""
    draft = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    mode: Literal["validation", "serialization"] = "serialization" if issubclass(SCHEMAS[name], Shape) else "validation"
    return json.dumps(draft | SCHEMAS[name].model_json_schema(mode=mode), indent=1, ensure_ascii=False) + "\n"


def row(model: type[BaseModel], key: str) -> str:
    """Returns the row of a key: unit by its name, default and meaning by the code."""
    field = model.model_fields[key]
    unit = unit_of(key).name or next((note.unit for note in field.metadata if isinstance(note, In)), "")
    cells = (f"`{key}`", unit, _default(field), " ".join(meanings(model).get(key, "").split()))
    return "|" + "|".join(f" {cell} " if cell else " " for cell in cells) + "|\n"


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    return "" if value is None else f"`{_toml(value)}`"


def _toml(value: Any) -> str:
    plain = value.value if isinstance(value, Enum) else str(value) if isinstance(value, Path) else value
    return json.dumps(plain, ensure_ascii=False)  # of such values TOML's spelling is JSON's


if __name__ == "__main__":
    for table_page in TABLES:
        (DOCS / table_page).write_text(page(table_page), encoding="utf-8")
