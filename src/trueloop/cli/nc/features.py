"""`trueloop nc features`: which blocks of a finish program cut which feature of the part."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import ExitStatus, as_dict, guarded, say
from trueloop.cli.terminal import AsJson, busy, print_json, wide_console

if TYPE_CHECKING:
    from trueloop.errors import TrueloopError
    from trueloop.geometry.feature import Feature
    from trueloop.loops.turned.edges import CutFeature
    from trueloop.nc.match.contour_match import FeatureMatch, MatchedMove
    from trueloop.nc.program.program import Program

SAMPLES = 65


@dataclass(frozen=True)
class CuttingBlock:
    """One move over a feature: its block, the arc lengths where it starts and ends, its largest deviation by size."""

    line: int
    block: str
    motion: str
    path: str
    from_mm: float
    to_mm: float
    deviation_um: float


@guarded
def features_of_job(
    job: Annotated[Path, typer.Argument(metavar="JOB.toml", help="The job file; its touches need not exist yet.")],
    as_json: AsJson = False,
) -> None:
    """Print which blocks of the finish program, and which tool, cut which feature.

    Exit status 1 when that is not plain for one.
    """
    from trueloop.errors import TrueloopError
    from trueloop.jobs.turned.job import read_finish
    from trueloop.loops.turned.edges import cut_by_one, cut_features

    with busy(f"matching {job}"):
        finish = read_finish(job)
        part, program, run = finish.part, finish.program, finish.run
        if part.edges:
            found = cut_features(program, run, part.profile, part.edges, finish.decided)
        else:
            found = cut_by_one(program, run, part.profile, part.nose_radius_mm)
    file = finish.program.file or str(job)
    rows = [_row(finish.program, one, file) for one in found]
    refusals = [row.match for row in rows if isinstance(row.match, TrueloopError)]
    if as_json:
        print_json({"part": part.name, "program": file, "features": [_object(row) for row in rows]})
    else:
        tools = list(dict.fromkeys(row.tool for row in rows if row.tool))
        by_one = f" with {tools[0]}" if len(tools) == 1 else ""
        _print_table(f"{part.name}, cut by {file}{by_one}", rows, several=len(tools) > 1)
        for refusal in refusals:
            say(refusal, as_json=False)
    if refusals:
        raise typer.Exit(ExitStatus.FINDINGS)


@dataclass(frozen=True)
class _Row:
    """A feature with the blocks that cut it."""

    feature: "Feature"
    tool: str
    match: "FeatureMatch | TrueloopError | None"
    blocks: tuple[CuttingBlock, ...]


def _row(program: "Program", found: "CutFeature", file: str) -> _Row:
    from trueloop.errors import TrueloopError

    if isinstance(found.match, TrueloopError):
        return _Row(found.feature, found.tool, found.match.in_file(file), ())
    blocks = () if found.match is None else _blocks(program, found.match)
    return _Row(found.feature, found.tool, found.match, blocks)


def _blocks(program: "Program", match: "FeatureMatch") -> tuple[CuttingBlock, ...]:
    return tuple(_block(program, match, moved) for moved in match.moves)


def _block(program: "Program", match: "FeatureMatch", moved: "MatchedMove") -> CuttingBlock:
    import numpy as np

    from trueloop.geometry.feature import Arc
    from trueloop.units import UM_PER_MM

    block, move = program.block(moved.move.line - 1), moved.move
    ends_mm = np.clip([moved.start_mm, moved.end_mm], 0.0, match.feature.length_mm)
    deviation_mm = match.deviation_mm(np.linspace(ends_mm[0], ends_mm[1], SAMPLES))
    return CuttingBlock(
        line=move.line,
        block=program.source[block.start : block.end].decode("latin-1").strip(),
        motion="arc" if isinstance(move.path, Arc) else "line",
        path=f"contour, G{move.compensation}" if move.on_contour else "nose centre",
        from_mm=moved.start_mm,
        to_mm=moved.end_mm,
        deviation_um=float(deviation_mm[np.argmax(np.abs(deviation_mm))]) * UM_PER_MM,
    )


def _object(row: _Row) -> dict[str, object]:
    from trueloop.errors import TrueloopError

    return {
        "name": row.feature.name,
        "length_mm": row.feature.length_mm,
        "tool": row.tool,
        "blocks": [asdict(block) for block in row.blocks],
        "error": as_dict(row.match) if isinstance(row.match, TrueloopError) else None,
    }


def _print_table(title: str, rows: "list[_Row]", several: bool) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for heading in (
        "feature",
        *(("tool",) if several else ()),
        "line",
        "block",
        "motion",
        "path",
        "from",
        "to",
        "of",
        "off nominal",
    ):
        number = heading in ("line", "from", "to", "of", "off nominal")
        table.add_column(heading, justify="right" if number else "left", no_wrap=True)
    for row in rows:
        named = (Text(row.feature.name), *((row.tool or "–",) if several else ()))
        length_mm = row.feature.length_mm
        for b in row.blocks:
            numbers = (f"{b.from_mm:.4f}", f"{b.to_mm:.4f}", f"{length_mm:.4f}", f"{b.deviation_um:+z.2f}")
            table.add_row(*named, str(b.line), Text(b.block), b.motion, b.path, *numbers)
        if not row.blocks:
            why = "left alone" if row.match is None else "not known"
            table.add_row(*named, "–", why, *("",) * 4, f"{length_mm:.4f}", "")
    console = wide_console()
    console.print(title + "\n", markup=False)
    console.print(table)
    console.print(
        "\nFrom, to, of: mm of arc along the feature, chuck end first. Off nominal: µm, the largest over the block, "
        "positive outwards.",
        markup=False,
    )
