"""`trueloop nc features`: which blocks of a finish program cut which feature of the part."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import ExitStatus, as_dict, guarded, say
from trueloop.cli.terminal import AsJson, busy, print_json, wide_console

if TYPE_CHECKING:
    from collections.abc import Sequence

    from trueloop.errors import TrueloopError
    from trueloop.geometry.feature import Feature
    from trueloop.geometry.setup_frame import SetupFrame
    from trueloop.loops.turned.edges import CutFeature
    from trueloop.nc.match.contour_match import FeatureMatch, MatchedMove
    from trueloop.nc.program.program import Program

SAMPLES = 65
LEGEND = (
    "From, to, of: mm of arc along the feature, chuck end first. Off nominal: µm, the largest over the block, "
    "positive outwards."
)


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
    """Print which blocks of the finish program, and which tool, cut which feature; of a job with set-ups, in each.

    Exit status 1 when that is not plain for one.
    """
    from trueloop.jobs.turned.compensate_setups import has_setups

    found = _of_setups(job) if has_setups(job) else _of_one(job)
    refusals = [*found.doubtful, *(refusal for cut in found.cuts for refusal in cut.refused)]
    if as_json:
        print_json(found.as_dict())
    else:
        for cut in found.cuts:
            _print_table(f"{found.part}, {cut.words}", cut.rows, cut.several)
        wide_console().print(LEGEND, *found.uncut_words, sep="\n", markup=False)
        for refusal in refusals:
            say(refusal, as_json=False)
    if refusals:
        raise typer.Exit(ExitStatus.FINDINGS)


def _of_one(job: Path) -> "_Found":
    from trueloop.jobs.turned.job import read_finish
    from trueloop.loops.turned.edges import cut_by_one, cut_features

    with busy(f"matching {job}"):
        finish = read_finish(job)
        part, program, run = finish.part, finish.program, finish.run
        if part.edges:
            found = cut_features(program, run, part.profile, part.edges, finish.decided)
        else:
            found = cut_by_one(program, run, part.profile, part.nose_radius_mm)
    return _Found(part.name, (_cut(program, found, job),))


def _of_setups(job: Path) -> "_Found":
    from trueloop.jobs.turned.job_files import JobFiles
    from trueloop.jobs.turned.setups import read_setups

    with busy(f"matching {job}"):
        files = JobFiles.of(job)
        found = read_setups(files).found
        cuts = tuple(_cut(one.setup.program, one.cut_features, job, one.setup.frame) for one in found.setups)
    doubtful = tuple(refusal.in_file(str(job)) for refusal in found.doubtful)
    return _Found(files.job.part.name, cuts, found.uncut, doubtful)


@dataclass(frozen=True)
class _Cut:
    """The features that one program cuts; `setup` is its frame where there are several."""

    file: str
    rows: "tuple[_Row, ...]"
    setup: "SetupFrame | None"

    @property
    def refused(self) -> "list[TrueloopError]":
        """Why it is not plain of some features."""
        from trueloop.errors import TrueloopError

        return [row.match for row in self.rows if isinstance(row.match, TrueloopError)]

    @property
    def tools(self) -> list[str]:
        """All that cut something."""
        return list(dict.fromkeys(row.tool for row in self.rows if row.tool))

    @property
    def several(self) -> bool:
        """Whether the table says which tool."""
        return len(self.tools) > 1

    @property
    def words(self) -> str:
        """`cut by finish.nc with T3`, with the set-up in front."""
        by_one = f" with {self.tools[0]}" if len(self.tools) == 1 else ""
        where = "" if self.setup is None else f"set-up {self.setup.name} ({self.setup.words} of the part), "
        return f"{where}cut by {self.file}{by_one}"

    def as_dict(self) -> dict[str, object]:
        """For machines."""
        named = {} if self.setup is None else {"name": self.setup.name, "z_of_program": self.setup.words}
        return {**named, "program": self.file, "features": [_object(row) for row in self.rows]}


@dataclass(frozen=True)
class _Found:
    """What a job's programs cut. `uncut`, `doubtful`: features that no set-up cuts, and why others are of none."""

    part: str
    cuts: tuple[_Cut, ...]
    uncut: tuple[str, ...] = ()
    doubtful: "tuple[TrueloopError, ...]" = ()

    @property
    def uncut_words(self) -> list[str]:
        """Features that no set-up cuts."""
        return [f"Cut in no set-up: {', '.join(self.uncut)}."] if self.uncut else []

    def as_dict(self) -> dict[str, object]:
        """For machines: a program, or one by set-up."""
        if self.cuts[0].setup is None:
            return {"part": self.part, **self.cuts[0].as_dict()}
        setups = [
            {"name": cut.setup.name, "z_of_program": cut.setup.words, **cut.as_dict()} for cut in self.cuts if cut.setup
        ]
        doubtful = [as_dict(refusal) for refusal in self.doubtful]
        return {"part": self.part, "setups": setups, "uncut": list(self.uncut), "doubtful": doubtful}


def _cut(program: "Program", found: "list[CutFeature]", job: Path, setup: "SetupFrame | None" = None) -> _Cut:
    file = program.file or str(job)
    return _Cut(file, tuple(_row(program, one, file) for one in found), setup)


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


def _print_table(title: str, rows: "Sequence[_Row]", several: bool) -> None:
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
    console.print()
