"""The meanings of a table's columns, as a TOML file that is proposed, shown, and kept beside the job."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Final, Literal

from pydantic import Field

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Unit
from trueloop.formats.inspections.shared.quantities import Deviation, LowerTolerance
from trueloop.formats.inspections.shared.text import Order
from trueloop.formats.inspections.tables.headings import POINT, Role
from trueloop.formats.toml_tables import Count, Table, read_tables, toml_keys
from trueloop.wording import did_you_mean, shell_word

HINT: Final = "docs/measurements.md, 'Tables by mapping'; `trueloop measure map FILE` writes one from the headings"


def map_command(table: Path, options: str = "") -> str:
    """Returns the command that writes a table's mapping, as a shell takes it."""
    return f"trueloop measure map {shell_word(str(table))} {options}".strip()


SEVERAL: Final = ("parts", "repeats", "characteristics", "ignored")
PAIRS: Final = ((Role.UPPER_LIMIT, Role.UPPER_TOLERANCE), (Role.LOWER_LIMIT, Role.LOWER_TOLERANCE))


class Columns(Table):
    """Headings by what is under them. A heading that is there twice is `X`, then `X#2`; one without text is `#4`."""

    characteristic: str | None = None
    """Name of what was measured."""
    feature: str | None = None
    """Name of the feature."""
    quantity: str | None = None
    """Its quantity, diameter, length …, by words, symbols or letters of a GD&T font."""
    nominal: str | None = None
    """Nominal values."""
    actual: str | None = None
    """Actual values."""
    deviation: str | None = None
    """Deviations."""
    upper_limit: str | None = None
    """Upper limits, absolute."""
    lower_limit: str | None = None
    """Lower limits, absolute."""
    upper_tolerance: str | None = None
    """Upper tolerances, counted from the nominal value."""
    lower_tolerance: str | None = None
    """Lower tolerances, counted from the nominal value."""
    tolerance: str | None = None
    """Both in one: `±0.02`, `+0.02/-0.01`."""
    unit: str | None = None
    """The unit of the row."""
    x: str | None = None
    """x of a point, or of a value's place."""
    y: str | None = None
    """y of a point, or of a value's place."""
    z: str | None = None
    """z of a point, or of a value's place."""
    nominal_x: str | None = None
    """Nominal x of a point."""
    nominal_y: str | None = None
    """Nominal y of a point."""
    nominal_z: str | None = None
    """Nominal z of a point."""
    i: str | None = None
    """x of a point's normal."""
    j: str | None = None
    """y of a point's normal."""
    k: str | None = None
    """z of a point's normal."""
    part: str | None = None
    """The part's type."""
    serial: str | None = None
    """Its serial number."""
    date: str | None = None
    """Day of the measurement."""
    time: str | None = None
    """Time of the measurement."""
    operator: str | None = None
    """Who measured."""
    device: str | None = None
    """By what."""
    temperature: str | None = None
    """Temperature in °C."""
    repeat: str | None = None
    """Which reading of several."""
    verdict: str | None = None
    """The file's verdict on the value; it is compared."""
    outside: str | None = None
    """By how much a value is beyond its limits; it is compared."""
    parts: tuple[str, ...] = ()
    """Columns of actual values, each of one part; their headings are the serial numbers."""
    repeats: tuple[str, ...] = ()
    """Columns of actual values, each of one reading of the same characteristic and part."""
    characteristics: tuple[str, ...] = ()
    """Columns of actual values, each of one characteristic; a row is a part."""
    ignored: tuple[str, ...] = ()
    """Columns that say nothing here."""

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
        """True if the table holds sizes; else it holds points."""
        return bool(self.values) or self.actual is not None or self.deviation is not None

    def all(self) -> Iterator[str]:
        """All headings that the mapping names."""
        yield from self.named().values()
        for several in SEVERAL:
            yield from getattr(self, several)


class RowLabels(Table):
    """Rows of a table of one row a part that hold no part: by the text in the first column of the mapping's parts."""

    nominal: str | None = None
    """The row of nominal values."""
    upper_limit: str | None = None
    """The row of upper limits."""
    lower_limit: str | None = None
    """The row of lower limits."""
    upper_tolerance: str | None = None
    """The row of upper tolerances."""
    lower_tolerance: str | None = None
    """The row of lower tolerances."""
    tolerance: str | None = None
    """The row of both in one."""
    unit: str | None = None
    """The row of units."""

    def named(self) -> dict[Role, str]:
        """The labels by what the row holds."""
        return {Role(key): label for key in type(self).model_fields if (label := getattr(self, key)) is not None}


class Mapping(Table):
    """A table's mapping: where its headings are, and what it does not say itself."""

    sheet: str = ""
    """Which sheet of a workbook; left out, the first that is visible."""
    separator: Literal["", ",", ";", "|", "\t"] = ""
    """Between columns; left out, it is found."""
    header_row: Count = 1
    """The row of the headings, from 1."""
    header_rows: Literal[1, 2] = 1
    """How many rows they take."""
    unit: Unit | None = None
    """Of the file's lengths, where it does not say."""
    deviation: Deviation | None = None
    """Which way deviations are counted, where the rows do not show it."""
    lower_tolerance: LowerTolerance | None = None
    """Sign of lower tolerances, where the rows do not show it."""
    dates: Order | None = None
    """How dates are written, where they do not show it."""
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
    for role, other in PAIRS:
        if role in named and other in named:
            raise refusal(code, path, f"{role} and {other} are 2 columns for one limit", "keep one of them")
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
    """Raises MSR-MAPPING where a column that the mapping names is not one of the table's."""
    wanted = list(mapping.columns.all())
    missing = [name for name in wanted if name not in names]
    if not missing:
        return
    if 2 * len(missing) > len(wanted):
        why = f"{len(missing)} of the {len(wanted)} columns of the mapping are not in the table: it is of another table"
        raise Code.MSR_MAPPING.refusal(why, hint=HINT, place=place)
    raise Code.MSR_MAPPING.refusal(
        f"{missing[0]!r}, which the mapping names, is not one of the table's {len(names)} columns",
        hint=did_you_mean(missing[0], names) or f"its columns are {', '.join(map(repr, names))}",
        place=Place(str(mapping_path)) if mapping_path else place,
    )


def refusal(code: Code, path: Path, why: str, hint: str) -> TrueloopError:
    """The refusal of a mapping, or of headings that make none."""
    values = {"file": path.name} if code.values else {}
    return code.refusal(why, hint=hint, place=Place(str(path)), values=values)


def toml_of(mapping: Mapping, title: str) -> str:
    """A mapping as TOML, only what it says."""
    lines = [f"# {title}"]
    content = mapping.model_dump(exclude_none=True, exclude_defaults=True)
    content["header_row"] = mapping.header_row
    tables = {key: value for key, value in content.items() if isinstance(value, dict)}
    lines += toml_keys({key: value for key, value in content.items() if key not in tables})
    for name, table in tables.items():
        if table:
            lines += ["", f"[{name}]", *toml_keys(table)]
    return "\n".join(lines) + "\n"
