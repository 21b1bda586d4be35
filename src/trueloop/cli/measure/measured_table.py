"""An inspection file in words and numbers, for `trueloop measure read`."""

from typing import Final

from trueloop.cli.terminal import print_lines, wide_console
from trueloop.report.measured import FileOnPart, OnPart, ValueRow, rows_of

MOST: Final = 200
"""Rows of a table: nobody reads more on a screen."""
NAMED: Final = 6
"""Names in a list of values that have one thing in common."""
VERDICTS: Final = {True: "in", False: "OUT", None: ""}


def print_file(file: FileOnPart) -> None:
    """The file's own facts, a table for each inspection, what was not matched, and remarks."""
    read = file.file
    count = len(file.on_part)
    print_lines(
        [
            f"{read.path}: {read.format}, {read.encoding}, unit {read.unit or 'not stated'}, "
            f"{count} {'inspection' if count == 1 else 'inspections'}"
        ]
    )
    for one in file.on_part:
        print_lines(["", _heading(one)])
        rows = list(rows_of(file, one))
        _print_table([row for row in rows if not row.reason], matched=one.matches is not None)
        _print_left([row for row in rows if row.reason and row.is_error])
        _print_kept([row for row in rows if row.reason and not row.is_error])
        print_lines(one.findings)
    if read.remarks:
        print_lines(["", "remarks:"])
        print_lines(f"  line {one.line}: {one.text}" if one.line else f"  {one.text}" for one in read.remarks[:MOST])
    print_lines([""])


def _heading(one: OnPart) -> str:
    inspection, matches = one.inspection, one.matches
    part = inspection.part
    said = [
        f"{one.run}.",
        part.part_type.name or "part not stated",
        f"serial {part.serial}" if part.serial else "serial not stated",
        *([f"{inspection.measured_at:%Y-%m-%d %H:%M}"] if inspection.measured_at else []),
        *([inspection.device] if inspection.device else []),
        f"{inspection.count} {inspection.measured}",
    ]
    if matches is not None:
        total = matches.count + len(matches.unmatched)
        said.append(f"{matches.count} of {total} matched")
        if matches.axis is not None:
            said.append(f"spindle along {matches.axis}")
    return f"{said[0]} {', '.join(said[1:])}"


def _print_table(rows: list[ValueRow], *, matched: bool) -> None:
    if not rows:
        return
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for name in ("characteristic", "quantity", "feature", *(("by",) if matched else ())):
        table.add_column(name)
    numbers = (*(("away mm",) if matched else ()), "nominal", "actual", "deviation", "lower", "upper")
    for name in numbers:
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("")
    placed = any(row.place_mm for row in rows)
    if placed:
        table.add_column("place mm")
    for row in rows[:MOST]:
        table.add_row(*_cells(row, matched=matched), *([_place(row)] if placed else []))
    wide_console().print(table)
    if len(rows) > MOST:
        print_lines([f"… and {len(rows) - MOST} more: --json has all"])


def _cells(row: ValueRow, *, matched: bool) -> list[str]:
    from rich.markup import escape

    name = row.characteristic if row.repeat == 1 else f"{row.characteristic} ({row.repeat})"
    found = [row.by] if matched else []
    away = [_number(row.distance_mm, "z.4f")] if matched else []
    limits = [_number(one, ".4f") for one in (row.lower_limit, row.upper_limit)]
    sizes = [_number(row.nominal, ".4f"), _number(row.actual, ".4f"), _number(row.deviation, "+z.4f"), *limits]
    words = [escape(one) for one in (name, row.quantity, row.feature, *found)]
    return [*words, *away, *sizes, VERDICTS[row.within]]


def _number(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _place(row: ValueRow) -> str:
    return " ".join(f"{one:.4f}" for one in row.place_mm)


def _print_left(rows: list[ValueRow]) -> None:
    if not rows:
        return
    print_lines(["", f"not matched: {len(rows)}"])
    for row in rows[:MOST]:
        where = f" (line {row.line})" if row.line else ""
        print_lines([f"  {row.characteristic or row.quantity}{where}: {row.reason}"])
    if len(rows) > MOST:
        print_lines([f"  … and {len(rows) - MOST} more: --json has all"])


def _print_kept(rows: list[ValueRow]) -> None:
    """By reason, for they are many where each circle has its position and its form."""
    if not rows:
        return
    print_lines(["", f"no errors of the profile, kept: {len(rows)}"])
    for reason in dict.fromkeys(row.reason for row in rows):
        names = [row.characteristic or row.quantity for row in rows if row.reason == reason]
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        print_lines([f"  {', '.join(names[:NAMED])}{more}: {reason}"])
