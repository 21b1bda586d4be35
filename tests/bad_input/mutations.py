"""Small changes to the files of a sound job, each one thing that people get wrong."""

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

Mutation: TypeAlias = Callable[[Path], None]
"""Changes files in a folder that holds the example job."""

Rows: TypeAlias = list[dict[str, str]]


def rewrite(name: str, before: str, after: str, count: int = 1) -> Mutation:
    """Replaces text that the file is known to hold."""

    def mutate(folder: Path) -> None:
        path = folder / name
        text = path.read_bytes().decode("latin-1" if name.endswith(".nc") else "utf-8")
        assert text.count(before) >= 1, f"{name} holds no {before!r}"
        path.write_bytes(text.replace(before, after, count).encode("latin-1" if name.endswith(".nc") else "utf-8"))

    return mutate


def job(before: str, after: str) -> Mutation:
    """Changes the job file."""
    return rewrite("job.toml", before, after)


def touches(change: Callable[[Rows], None], name: str = "touches.csv") -> Mutation:
    """Changes the touches as rows, or writes another file of them; comments stay, so do line numbers."""

    def mutate(folder: Path) -> None:
        lines = (folder / "touches.csv").read_text().splitlines()
        comments = [line for line in lines if line.startswith("#")]
        reader = csv.DictReader(lines[len(comments) :])
        rows = list(reader)
        change(rows)
        out = io.StringIO()
        writer = csv.DictWriter(out, reader.fieldnames or [], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        (folder / name).write_text("\n".join([*comments, out.getvalue()]))

    return mutate


def cell(row: int, column: str, value: str) -> Mutation:
    """One cell of the touches, rows counted from 0."""
    return touches(lambda rows: rows[row].update({column: value}))


def scaled(factors: dict[str, float]) -> Mutation:
    """Whole columns multiplied."""

    def change(rows: Rows) -> None:
        for row in rows:
            row.update({name: repr(float(row[name]) * factor) for name, factor in factors.items()})

    return touches(change)


def both(*mutations: Mutation) -> Mutation:
    """One after the other."""

    def mutate(folder: Path) -> None:
        for mutation in mutations:
            mutation(folder)

    return mutate
