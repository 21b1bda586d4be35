"""What the columns of a table mean, as a TOML file that is proposed, shown, and kept beside the job."""

import difflib
import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Final, Literal

from pydantic import Field

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Unit
from trueloop.formats.inspections.shared.conventions import Deviation, LowerTolerance
from trueloop.formats.inspections.shared.times import Order
from trueloop.formats.inspections.tables.roles import POINT, Role
from trueloop.formats.toml_tables import Count, Table, read_tables

HINT: Final = "docs/measurements.md, 'Tables by mapping'; `trueloop measure map FILE` writes one from the headings"
SEVERAL: Final = ("parts", "repeats", "characteristics", "ignored")
PAIRS: Final = ((Role.UPPER_LIMIT, Role.UPPER_TOLERANCE), (Role.LOWER_LIMIT, Role.LOWER_TOLERANCE))


class Columns(Table):
    """Headings by what is under them. A heading that is there twice is `X`, then `X#2`; one without text is `#4`."""

    characteristic: str | None = None
    feature: str | None = None
    quantity: str | None = None
    nominal: str | None = None
    actual: str | None = None
    deviation: str | None = None
    upper_limit: str | None = None
    lower_limit: str | None = None
    upper_tolerance: str | None = None
    lower_tolerance: str | None = None
    tolerance: str | None = None
    unit: str | None = None
    x: str | None = None
    y: str | None = None
    z: str | None = None
    nominal_x: str | None = None
    nominal_y: str | None = None
    nominal_z: str | None = None
    i: str | None = None
    j: str | None = None
    k: str | None = None
    part: str | None = None
    serial: str | None = None
    date: str | None = None
    time: str | None = None
    operator: str | None = None
    device: str | None = None
    temperature: str | None = None
    repeat: str | None = None
    verdict: str | None = None
    outside: str | None = None
    parts: tuple[str, ...] = ()
    """Columns of actual values, each of one part; their headings are the serial numbers."""
    repeats: tuple[str, ...] = ()
    """Columns of actual values, each of one reading of the same characteristic and part."""
    characteristics: tuple[str, ...] = ()
    """Columns of actual values, each of one characteristic; a row is a part."""
    ignored: tuple[str, ...] = ()

    def named(self) -> dict[Role, str]:
        """The columns of one thing each."""
        return {role: name for role in Role if (name := getattr(self, role.value)) is not None}

    @property
    def label(self) -> str | None:
        """The column that says what a row of several characteristics is: a part, or nominal values and limits."""
        return self.serial or self.date or self.time

    @property
    def values(self) -> tuple[str, ...]:
        """The columns of actual values where there are several."""
        return self.parts or self.repeats or self.characteristics

    @property
    def has_values(self) -> bool:
        """Whether the table holds sizes; else it holds points."""
        return bool(self.values) or self.actual is not None or self.deviation is not None

    def all(self) -> Iterator[str]:
        """All headings that the mapping names."""
        yield from self.named().values()
        for several in SEVERAL:
            yield from getattr(self, several)


class RowLabels(Table):
    """Rows of a table of one row a part that hold no part: by the text in the first column of the mapping's parts."""

    nominal: str | None = None
    upper_limit: str | None = None
    lower_limit: str | None = None
    upper_tolerance: str | None = None
    lower_tolerance: str | None = None
    unit: str | None = None

    def named(self) -> dict[Role, str]:
        """The labels by what the row holds."""
        return {Role(key): label for key in type(self).model_fields if (label := getattr(self, key)) is not None}


class Mapping(Table):
    """A table's mapping: where its headings are, and what it does not say itself."""

    sheet: str = ""
    separator: Literal["", ",", ";", "|", "\t"] = ""
    header_row: Count = 1
    header_rows: Literal[1, 2] = 1
    unit: Unit | None = None
    deviation: Deviation | None = None
    lower_tolerance: LowerTolerance | None = None
    dates: Order | None = None
    columns: Columns
    rows: RowLabels = Field(default_factory=RowLabels)
    units: dict[str, str] = Field(default_factory=dict)
    """Units by column, where the heading names none: `deviation = "µm"`."""
    features: dict[str, str] = Field(default_factory=dict)
    """Names of features in the file that the part's profile names otherwise."""


def read_mapping(path: Path) -> Mapping:
    """A mapping file. Raises MSR-MAPPING for an unknown key, a column with two meanings, or two columns for one."""
    mapping = read_tables(path, Mapping, Code.MSR_MAPPING, hint=HINT)
    check(mapping, path)
    return mapping


def check(mapping: Mapping, path: Path, code: Code = Code.MSR_MAPPING) -> None:
    """Raises `code` where a column has two meanings, one thing two columns, or there is no value at all."""
    columns, named = mapping.columns, mapping.columns.named()
    twice = [name for name, count in Counter(columns.all()).items() if count > 1]
    if twice:
        raise refusal(
            code,
            path,
            f"column {twice[0]!r} is named {Counter(columns.all())[twice[0]]} times",
            "one column, one meaning",
        )
    for one, other in PAIRS:
        if one in named and other in named:
            raise refusal(code, path, f"{one} and {other} are 2 columns for one limit", "keep one of them")
    several = [name for name in ("parts", "repeats", "characteristics") if getattr(columns, name)]
    if Role.ACTUAL in named:
        several.append("actual")
    if len(several) > 1:
        raise refusal(
            code, path, f"{' and '.join(several)} are {len(several)} ways to name the actual values", "keep one of them"
        )
    if not several and not {Role.DEVIATION, Role.NOMINAL} <= named.keys() and not set(POINT) <= named.keys():
        raise refusal(
            code,
            path,
            "0 columns hold actual values",
            'name one: actual = "HEADING" under [columns], or --column actual=HEADING',
        )


def require_columns(mapping: Mapping, names: tuple[str, ...], place: Place, mapping_path: Path | None) -> None:
    """Raises MSR-MAPPING where a column that the mapping names is none of the table's."""
    wanted = list(mapping.columns.all())
    missing = [name for name in wanted if name not in names]
    if not missing:
        return
    if 2 * len(missing) > len(wanted):
        why = f"{len(missing)} of the {len(wanted)} columns of the mapping are not in the table: it is of another table"
        raise TrueloopError(Code.MSR_MAPPING, why, hint=HINT, place=place)
    near = difflib.get_close_matches(missing[0], names, n=1)
    raise TrueloopError(
        Code.MSR_MAPPING,
        f"{missing[0]!r}, which the mapping names, is none of the table's {len(names)} columns",
        hint=f"did you mean {near[0]!r}?" if near else f"its columns are {', '.join(map(repr, names))}",
        place=Place(str(mapping_path)) if mapping_path else place,
    )


def refusal(code: Code, path: Path, why: str, hint: str) -> TrueloopError:
    """The refusal of a mapping, or of headings that make none."""
    values = {"file": path.name} if code.values else {}
    return TrueloopError(code, why, hint=hint, place=Place(str(path)), values=values)


def toml_of(mapping: Mapping, title: str) -> str:
    """A mapping as TOML, only what it says."""
    lines = [f"# {title}"]
    content = mapping.model_dump(exclude_none=True, exclude_defaults=True)
    content["header_row"] = mapping.header_row
    tables = {key: value for key, value in content.items() if isinstance(value, dict)}
    lines += [f"{key} = {_toml(value)}" for key, value in content.items() if key not in tables]
    for name, table in tables.items():
        if table:
            lines += ["", f"[{name}]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_toml, value))}]"
    return json.dumps(value, ensure_ascii=False)
