"""docs/job-file.md lists every table and key of the job file, with the unit and the default that the code has."""

import json
import re
import tomllib
from enum import Enum
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import pytest
from pydantic.fields import FieldInfo

from scripts.key_tables import DOCS, SCHEMAS, TABLES, page, schema
from trueloop.formats.jobs import job

PAGE = (DOCS / "job-file.md").read_text(encoding="utf-8")
MODELS = TABLES["job-file.md"]
UNITS = {"_mm": "mm", "_um": "µm", "_in": "inch", "_um_per_mm": "µm/mm", "_hours": "h"}
ROW = re.compile(r"\| `(\w+)` \| (.*?) ?\| (.*?) ?\| (.+) \|")

Row = tuple[str, str, str]


def sections() -> dict[str, dict[str, Row]]:
    """Heading → key → (unit, default, meaning). Those of `[tool]` are also keys of `[[tools]]`."""
    found: dict[str, dict[str, Row]] = {}
    for part in PAGE.split("\n## ")[1:]:
        rows = [ROW.fullmatch(line) for line in part.splitlines()]
        found[part.splitlines()[0].strip("`")] = {row[1]: (row[2], row[3], row[4]) for row in rows if row}
    assert "has the keys of [`[tool]`](#tool), and:" in " ".join(PAGE.split())
    return {**found, "[[tools]]": {**found["[tool]"], **found["[[tools]]"]}}


def written_default(field: FieldInfo) -> object:
    default = field.get_default(call_default_factory=True)
    return str(default) if isinstance(default, Path) else list(default) if isinstance(default, tuple) else default


def choices(annotation: object) -> list[str]:
    """The values of every `Literal` and every enumeration in an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return [member.value for member in annotation]
    inner = get_args(annotation)
    return list(inner) if get_origin(annotation) is Literal else [c for each in inner for c in choices(each)]


def test_every_table_is_a_section_in_the_order_of_the_code() -> None:
    assert list(sections()) == list(MODELS)
    assert set(job.Job.model_fields) == {heading.strip("[]").split(".")[0] for heading in MODELS}


@pytest.mark.parametrize("heading", MODELS)
def test_every_key_is_listed_once_in_the_order_of_the_code(heading: str) -> None:
    assert list(sections()[heading]) == list(MODELS[heading].model_fields)


@pytest.mark.parametrize("heading", MODELS)
def test_defaults_are_those_of_the_code(heading: str) -> None:
    for key, field in MODELS[heading].model_fields.items():
        said = sections()[heading][key][1]
        if field.is_required():
            assert said == "required", key
        elif field.get_default(call_default_factory=True) is None:
            assert said == "", key
        else:
            value: dict[str, Any] = tomllib.loads(f"value = {said.strip('`')}")
            assert value["value"] == written_default(field), key


@pytest.mark.parametrize("heading", MODELS)
def test_a_unit_in_a_key_is_the_unit_on_the_page(heading: str) -> None:
    for key, (unit, _, _) in sections()[heading].items():
        endings = [ending for ending in UNITS if key.endswith(ending)]
        if endings:
            assert unit == UNITS[max(endings, key=len)], key


@pytest.mark.parametrize("heading", MODELS)
def test_every_choice_is_on_the_page(heading: str) -> None:
    for key, field in MODELS[heading].model_fields.items():
        for choice in choices(field.annotation):
            assert f'"{choice}"' in "".join(sections()[heading][key]), (key, choice)


@pytest.mark.parametrize("name", TABLES)
def test_tables_of_a_page_are_those_of_the_code(name: str) -> None:
    assert (DOCS / name).read_text(encoding="utf-8") == page(name), "run: python -m scripts.key_tables"


@pytest.mark.parametrize("name", SCHEMAS)
def test_schema_says_what_every_key_means_and_knows_no_others(name: str) -> None:
    read = json.loads(schema(name))
    for table in (read, *(t for t in read["$defs"].values() if "properties" in t)):
        assert table["additionalProperties"] is False
        assert all("description" in key or "$ref" in str(key) for key in table["properties"].values()), table["title"]


def test_schema_has_limits_with_unit_default_and_bound() -> None:
    table = json.loads(schema("job.schema.json"))["$defs"]["CompensationTable"]
    largest = table["properties"]["max_correction_um"]
    assert (largest["default"], largest["exclusiveMinimum"], largest["type"]) == (150.0, 0, "number")
