"""`trueloop realtime check` and `demo`: a recorded run judged by its model, and a run on a virtual lathe."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import ExitStatus, guarded
from trueloop.cli.terminal import AsJson, print_json

if TYPE_CHECKING:
    from trueloop.jobs.realtime.demo import Demo
    from trueloop.realtime.judge import Judged

SamplesFile = Annotated[
    Path, typer.Argument(metavar="SAMPLES.csv", help="A run, as `trueloop realtime watch` records.")
]
ModelFile = Annotated[Path, typer.Argument(metavar="MODEL.json", help="The model that the image was made from.")]
ImageFile = Annotated[Path | None, typer.Argument(metavar="[IMAGE]", help="The image: its table, tool and gate.")]


@guarded
def check(
    samples: SamplesFile,
    model: ModelFile,
    image: ImageFile = None,
    limit_nm: Annotated[float, typer.Option("--limit-nm", min=0.0, help="Most that may be left, nm RMS.")] = 2.0,
    slew: Annotated[float, typer.Option(min=1e-6, help="What `rtec.slew` was, mm/s.")] = 5.0,
    as_json: AsJson = False,
) -> None:
    """Judge a recorded run by the model itself. Exit status 1 when more is left, or a step was beyond the slew."""
    from trueloop.jobs.realtime.check import check_run

    found = check_run(samples, model, image, slew_mm_per_s=slew)
    if as_json:
        print_json({**_figures(found), "limit_nm": limit_nm, "within": found.within(limit_nm)})
    else:
        for line in judged_lines(found):
            typer.echo(line)
    if not found.within(limit_nm):
        raise typer.Exit(ExitStatus.FINDINGS)


@guarded
def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the results.")] = Path("out/realtime"),
    seed: Annotated[int, typer.Option(help="Of all noise.")] = 0,
    as_json: AsJson = False,
) -> None:
    """LinuxCNC turns a part on a virtual lathe that warms up, without the corrector and with it."""
    from rich.console import Console

    from trueloop.jobs.realtime.demo import demo as run

    with Console(stderr=True).status("starting") as status:
        made = run(output, seed, status.update)
    if as_json:
        print_json(_demo_figures(made))
        return
    for name, part in made.parts.items():
        typer.echo(f"{name + ':':<36} {part.rms_um:6.2f} µm RMS, {part.worst_um:6.2f} µm at the worst place")
    rms, worst = made.ratios
    typer.echo(f"{'with it to without errors:':<36} {rms:6.2f} x RMS, {worst:6.2f} x worst")
    typer.echo("left on the path in the cuts, normal to it, µm RMS:")
    for name, left in made.causes_um.items():
        typer.echo(f"  {name + ':':<56} {left:.3f}")
    for line in judged_lines(made.judged):
        typer.echo(line)
    typer.echo(f"written: {', '.join(str(file) for file in made.files)}")


def judged_lines(found: "Judged") -> tuple[str, ...]:
    """What a judge says, for people."""
    return (
        f"{int(found.judged.sum())} periods judged: {found.rms_nm:.4f} nm RMS left, {found.worst_nm:.4f} nm at most, "
        f"of {found.uncorrected_um:.1f} µm RMS",
        f"{found.reversals} reversals: {int(found.limited.sum())} periods limited by the slew, "
        f"{1e3 * found.longest_limited_s:.0f} ms at most in a row, {found.behind_nm:.4f} nm off what it allows",
        f"largest step of the correction {found.step_um:.3f} µm a period, the slew allows {found.most_step_um:.3f} µm",
    )


def _figures(found: "Judged") -> dict[str, float]:
    names = ("rms_nm", "worst_nm", "uncorrected_um", "reversals", "longest_limited_s", "behind_nm", "step_um")
    counts = {"judged": int(found.judged.sum()), "limited": int(found.limited.sum())}
    return counts | {name: getattr(found, name) for name in (*names, "most_step_um")}


def _demo_figures(made: "Demo") -> dict[str, object]:
    parts = {name: {"rms_um": part.rms_um, "worst_um": part.worst_um} for name, part in made.parts.items()}
    return {"parts": parts, "ratios": made.ratios, "left_um": made.causes_um, "judged": _figures(made.judged)}
