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
    """Print which blocks of the finish program cut which feature. Exit status 1 when that is not plain for one."""
    from trueloop.errors import TrueloopError
    from trueloop.jobs.turned.job import read_finish
    from trueloop.nc.match.matching import match_each
    from trueloop.nc.program.feed_moves import feed_moves

    with busy(f"matching {job}"):
        finish = read_finish(job)
        part, moves = finish.part, feed_moves(finish.run.of(finish.program))
        found = match_each(moves, part.profile, part.nose_radius_mm, lines=finish.run.lines)
    file = finish.program.file or str(job)
    matches = [match.in_file(file) if isinstance(match, TrueloopError) else match for match in found]
    blocks = [() if isinstance(match, TrueloopError) else _blocks(finish.program, match) for match in matches]
    features, refusals = part.profile.features, [match for match in matches if isinstance(match, TrueloopError)]
    if as_json:
        print_json({"part": part.name, "program": file, "features": _objects(features, matches, blocks)})
    else:
        _print_table(f"{part.name}, cut by {file}", features, blocks)
        for refusal in refusals:
            say(refusal, as_json=False)
    if refusals:
        raise typer.Exit(ExitStatus.FINDINGS)


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


def _objects(
    features: "tuple[Feature, ...]",
    matches: "list[FeatureMatch | TrueloopError]",
    blocks: list[tuple[CuttingBlock, ...]],
) -> list[dict[str, object]]:
    from trueloop.errors import TrueloopError

    return [
        {
            "name": feature.name,
            "length_mm": feature.length_mm,
            "blocks": [asdict(block) for block in cutting],
            "error": as_dict(match) if isinstance(match, TrueloopError) else None,
        }
        for feature, match, cutting in zip(features, matches, blocks, strict=True)
    ]


def _print_table(title: str, features: "tuple[Feature, ...]", blocks: list[tuple[CuttingBlock, ...]]) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for heading in ("feature", "line", "block", "motion", "path", "from", "to", "of", "off nominal"):
        number = heading in ("line", "from", "to", "of", "off nominal")
        table.add_column(heading, justify="right" if number else "left", no_wrap=True)
    for feature, cutting in zip(features, blocks, strict=True):
        for b in cutting:
            numbers = (f"{b.from_mm:.4f}", f"{b.to_mm:.4f}", f"{feature.length_mm:.4f}", f"{b.deviation_um:+z.2f}")
            table.add_row(Text(feature.name), str(b.line), Text(b.block), b.motion, b.path, *numbers)
        if not cutting:
            table.add_row(Text(feature.name), "–", "not known", *("",) * 4, f"{feature.length_mm:.4f}", "")
    console = wide_console()
    console.print(title + "\n", markup=False)
    console.print(table)
    console.print(
        "\nFrom, to, of: mm of arc along the feature, chuck end first. Off nominal: µm, the largest over the block, "
        "positive outwards.",
        markup=False,
    )
