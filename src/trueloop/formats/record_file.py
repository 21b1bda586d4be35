"""The record of a correction as JSON."""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, Final, TypeVar, get_args

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from trueloop.domain.record import CONTENT, Record, content_sha256
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_text
from trueloop.formats.outputs import Named

T = TypeVar("T")


def read_json(path: Path, name: str, made: Callable[[dict[str, Any]], T], *, hint: str) -> T:
    """Returns `made` of the file's content. Raises MCH-FILE where its "format" is not `name`, or `made` fails."""
    text = read_text(path, Code.MCH_FILE, hint=hint)
    try:
        with in_file(path):
            content = json.loads(text)
            if content["format"] != name:
                raise ValueError(f"format {content['format']!r} is not {name!r}")
            return made(content)
    except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        raise Code.MCH_FILE.refusal(
            f"{path.name!r} is no {name}: {type(error).__name__}: {error}", hint=hint, place=Place(str(path))
        ) from error


SCHEMA: Final[int] = get_args(Record.__annotations__["schema"])[0]
HINT: Final = "name the record.json or STEM.record.json that stands beside a corrected program"
WHOLE: Final = "restore the file as trueloop wrote it"


def read_record(path: Path) -> Record:
    """Reads a record. Raises REC-FILE (no JSON, no record), REC-SCHEMA (of a later version) and REC-KEY."""
    text = read_text(path, Code.REC_FILE, hint=HINT)
    content = _parsed(path, text)
    stated, found = content.pop(CONTENT, None), content_sha256(content)
    _require_known_schema(path, content)
    try:
        record = _adapter().validate_python(content)
    except ValidationError as error:
        raise _refused_key(path, text, error.errors()[0]) from error
    _require_unchanged(path, stated, found)
    return record


def record_of_edge(path: Path, setup: str, called: tuple[int, int], sha256: str) -> str | None:
    """Returns the id of an edge's correction that a `part.json` lists, None where nothing was measured of that edge.

    `called`: number and edge of its tool, in a set-up of that name, "" where the job has none; `sha256` of the program
    that the corrections have to be of. Raises REC-FILE, also where the edge is not listed, and CMP-OTHER-PROGRAM.
    """
    text = read_text(path, Code.REC_FILE, hint=HINT)
    try:
        content = json.loads(text)
        setups = content["setups"] if setup else [{**content, "name": ""}]
        of_setup = [one for one in setups if one["name"] == setup]
        edges = [edge for one in of_setup for edge in one["edges"]]
        ids = [edge["record_id"] for edge in edges if (edge["number"], edge["edge"]) == called]
        given = [str(one["source_sha256"]) for one in of_setup]
    except (ValueError, LookupError, TypeError, RecursionError) as error:
        raise _no_part(path, f"{type(error).__name__}: {error}") from error
    where = f" in set-up {setup!r}" if setup else ""
    if not ids or not all(one is None or isinstance(one, str) for one in ids):
        raise _no_part(path, f"it lists no edge {called[1]} of tool {called[0]}{where}")
    if sha256 not in given:
        raise Code.CMP_OTHER_PROGRAM.refusal(
            f"the corrections of {path.name!r} are of the program with sha256 {given[0][:16]}…, this one has "
            f"{sha256[:16]}…",
            hint="name in `programs.finish` the program that the corrections were made from",
            place=Place(str(path)),
            values={"expected_sha256": given[0], "found_sha256": sha256},
        )
    found: str | None = ids[0]
    return found


def _no_part(path: Path, why: str) -> TrueloopError:
    return Code.REC_FILE.refusal(
        f"{path.name!r} is not the list of a part's corrections: {why}", hint=WHOLE, place=Place(str(path))
    )


def record_beside(target: Path, record: Record) -> Named:
    """Returns the record of a written program, as a file beside it."""
    return f"{target.stem}.record.json", record.to_json().encode()


@cache
def _adapter() -> TypeAdapter[Record]:
    return TypeAdapter(Record)


def _parsed(path: Path, text: str) -> dict[str, Any]:
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        place = Place(str(path), error.lineno, error.colno)
        raise Code.REC_FILE.refusal(f"no JSON from here on: {error.msg!r}", hint=WHOLE, place=place) from error
    except (ValueError, RecursionError) as error:
        raise Code.REC_FILE.refusal(f"no JSON: {str(error)!r}", hint=WHOLE, place=Place(str(path))) from error
    if not isinstance(content, dict) or not {"id", "inputs_sha256"} & content.keys():
        found = sorted(content)[:5] if isinstance(content, dict) else type(content).__name__
        message = f"no record of a correction: {found!r} instead of an 'id' and 'inputs_sha256'"
        raise Code.REC_FILE.refusal(message, hint=HINT, place=Place(str(path)))
    return content


def _require_unchanged(path: Path, stated: object, found: str) -> None:
    """Raises REC-FILE for a content that was edited."""
    if stated in (None, found):
        return
    raise Code.REC_FILE.refusal(
        f"{path.name!r} was changed after trueloop wrote it: its content has sha256 {found[:16]}…, it states "
        f"{str(stated)[:16]}…",
        hint=f"{WHOLE}, or compensate anew: a correction that was cut with other values is not the one it names",
        place=Place(str(path)),
    )


def _require_known_schema(path: Path, content: dict[str, Any]) -> None:
    schema = content.get("schema")
    if isinstance(schema, int) and schema > SCHEMA:
        version = content.get("trueloop_version")
        raise Code.REC_SCHEMA.refusal(
            f"schema {schema}, written by trueloop {version}; this version reads up to {SCHEMA}",
            hint="read it with the version that wrote it, or a later one",
            place=Place(str(path)),
        )


def _refused_key(path: Path, text: str, mistake: ErrorDetails) -> TrueloopError:
    """The first key that is wrong: where it stands, or, where it is missing, its name."""
    location = [part for part in mistake["loc"] if not str(part).startswith("tuple[")]
    key = ".".join(map(str, location))
    missing = mistake["type"] == "missing"
    message = f"{key!r} is missing" if missing else f"{key!r}: {mistake['msg']}, given {_short(mistake['input'])}"
    return Code.REC_KEY.refusal(message, hint=WHOLE, place=Place(str(path), _line_of(text, location)))


def _line_of(text: str, location: list[int | str]) -> int | None:
    """The line of the outermost key: those inside may stand in many places."""
    lines = enumerate(text.splitlines(), 1)
    return next((number for number, line in lines if line.startswith(f'  "{location[0]}":')), None)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}…"
