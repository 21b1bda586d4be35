"""`trueloop surface compare`: parts cut after a correction beside those cut before."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, busy, print_json

if TYPE_CHECKING:
    from trueloop.loops.surface.compare import Comparison, PartFigures, Spread


@guarded
def compare(
    before: Annotated[Path, typer.Argument(metavar="BEFORE.toml", help="The job of the parts cut before.")],
    after: Annotated[Path, typer.Argument(metavar="AFTER.toml", help="The job of the parts cut after.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder for the results.  [default: output.folder of the job after]"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Set parts cut after a correction beside those before: deterministic, random, worst."""
    from trueloop.formats.outputs import write_all
    from trueloop.loops.surface.compare import compare as compared
    from trueloop.loops.surface.inputs import read_surface_inputs
    from trueloop.loops.surface.surface import Work
    from trueloop.report.surface.compare_page import compare_page

    with busy(f"comparing {before} and {after}") as told:
        jobs = read_surface_inputs(before), read_surface_inputs(after)
        found = compared(*jobs, Work(told=told))
        figures = _figures(found)
        contents = [
            ("compare.html", compare_page(found).encode()),
            ("compare.json", (json.dumps(figures, indent=1, ensure_ascii=False) + "\n").encode()),
        ]
        files = write_all(output or jobs[1].output_folder, contents, (*jobs[0].files, *jobs[1].files))
    if as_json:
        print_json({**figures, "files": list(map(str, files))})
        return
    _say(found, [*map(str, found.findings), *map(str, files)])


def _figures(found: "Comparison") -> dict[str, object]:
    from trueloop.report.surface.compare_page import rows_of

    groups = {"before": found.before, "after": found.after}
    return {
        which: {
            "name": group.name,
            "parts": [_part(part) for part in group.figures],
            "worst_part": group.figures[group.worst].name,
            **{name.replace(" ", "_"): _spread(spreads[side]) for name, *spreads in rows_of(found)},
        }
        for side, (which, group) in enumerate(groups.items())
    } | {"findings": [f"{finding.code}: {finding.message}" for finding in found.findings]}


def _part(part: "PartFigures") -> dict[str, object]:
    spreads = {name: _spread(getattr(part, name)) for name in ("measured", "deterministic", "random")}
    return {"name": part.name, **spreads}


def _spread(spread: "Spread") -> dict[str, float]:
    from trueloop.units import UM_PER_MM

    names = {"rms_um": spread.rms_mm, "low_um": spread.low_mm, "high_um": spread.high_mm, "worst_um": spread.worst_mm}
    return {name: value * UM_PER_MM for name, value in names.items()}


def _say(found: "Comparison", more: list[str]) -> None:
    from trueloop.report.surface.compare_page import rows_of
    from trueloop.units import UM_PER_MM

    groups = (found.before, found.after)
    counts = [f"{which}: {len(group.kept)} parts" for which, group in zip(("before", "after"), groups, strict=True)]
    print(f"{'Deviation in µm':<22}{counts[0]:>22}{counts[1]:>22}{'after ÷ before':>16}")
    for name, before, after in rows_of(found):
        share = f"{after.rms_mm / before.rms_mm:.2f}" if before.rms_mm else "–"
        cells = [f"{s.rms_mm * UM_PER_MM:.2f} RMS" for s in (before, after)]
        print(f"{name:<22}{cells[0]:>22}{cells[1]:>22}{share:>16}")
        ranges = [f"{s.low_mm * UM_PER_MM:+.1f} to {s.high_mm * UM_PER_MM:+.1f}" for s in (before, after)]
        print(f"{'  range':<22}{ranges[0]:>22}{ranges[1]:>22}")
    worst = [group.figures[group.worst] for group in groups]
    told = [f"{part.measured.worst_mm * UM_PER_MM:+.1f} ({part.name})" for part in worst]
    share = f"{abs(worst[1].measured.worst_mm / worst[0].measured.worst_mm):.2f}" if worst[0].measured.worst_mm else "–"
    print(f"{'worst (part)':<22}{told[0]:>22}{told[1]:>22}{share:>16}")
    for line in more:
        print(line)
