"""`trueloop diagnose`: from errors of parts to their causes."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

import typer

from trueloop.cli.options import AcceptRefused, Supersede, kept_as_dict, print_findings
from trueloop.cli.shared_options import Db, ModelOption, Page, argument, option, positive
from trueloop.cli.terminal import AsJson, ExitStatus, Group, busy, finding_lines, print_files, print_json, print_lines

if TYPE_CHECKING:
    from trueloop.jobs.diagnose.seen_series import DiagnosisOptions
    from trueloop.report.diagnosis.shapes import PartDiagnosisShape, SeriesDiagnosisShape
    from trueloop.report.series.values import FindingShape
    from trueloop.report.shape import Shape
    from trueloop.report.texts.texts import Texts

    Share = TypeVar("Share", PartDiagnosisShape, SeriesDiagnosisShape)

Output = Annotated[Path | None, option("Folder for page and JSON.  [default: none]", "--output", "-o")]
Element = Annotated[
    list[str] | None,
    option(
        "The temperature of what carries an axis; several times.  [default: what the model's terms take]",
        "--element",
        metavar="AXIS=SIGNAL",
    ),
]
Types = Annotated[list[str] | None, option("Of this part type alone; several times.  [default: all]", "--type", "-t")]


@dataclass(frozen=True, kw_only=True)
class Of:
    """Selects the parts, and adds facts about them."""

    part_type: Annotated[str | None, option("The part type.  [default: the only one in the store]", "--type", "-t")] = (
        None
    )
    job: Annotated[
        Path | None,
        option(
            "The job with the part's profile.  [default: the last correction's, else features by names]", "--job", "-j"
        ),
    ] = None
    model: Annotated[
        Path | None,
        option(
            "The machine's model, for what its probe reported.  [default: none]", "--model", "-m", metavar="MODEL.json"
        ),
    ] = None

    def asked(self, accept: list[str] | None) -> "DiagnosisOptions":
        """As jobs take it."""
        from trueloop.jobs.diagnose.seen_series import DiagnosisOptions

        return DiagnosisOptions(self.part_type, self.job, self.model, tuple(accept or ()))


def elements_of(texts: list[str] | None) -> dict[str, str]:
    """`["X=T2"]` as {"X": "T2"}."""
    found = {}
    for text in texts or ():
        axis, equals, signal = (part.strip() for part in text.partition("="))
        if not (axis and equals and signal):
            raise typer.BadParameter(f"{text!r} is no AXIS=SIGNAL", param_hint="--element")
        found[axis] = signal
    return found


def print_diagnosis(
    shape: "Shape", lines: Iterable[str], findings: "Iterable[FindingShape]", files: list[str], *, as_json: bool
) -> None:
    """As JSON with the files' names, or as lines."""
    if as_json:
        print_json({**shape.model_dump(mode="json"), "files": files})
        return
    print_lines([*lines, *finding_lines(findings)])
    print_files(files)


def _written(
    shares: "Sequence[Share]", name: str, page_of: "Callable[[Share, Texts], str]", folder: Path | None, page: Page
) -> list[list[str]]:
    """The files of each diagnosis; of a part that several edges cut with the edge in their names."""
    from trueloop.report.markup import write_page

    names = [name if len(shares) == 1 else f"{name}-{_file_name(share.part_type)}" for share in shares]
    return [
        write_page(shape, called, page_of, folder, page.language, page.unit)
        for shape, called in zip(shares, names, strict=True)
    ]


def _file_name(part_type: str) -> str:
    return "".join(one if one.isalnum() or one in "-_." else "_" for one in part_type.replace(", ", "-"))


def _print_shares(
    shares: "Sequence[Share]", lines: "Callable[[Share], Iterable[str]]", files: list[list[str]], *, as_json: bool
) -> None:
    """One diagnosis; or that of each edge of a part that several cut, in JSON as a list `shares`."""
    if len(shares) == 1:
        print_diagnosis(shares[0], lines(shares[0]), shares[0].findings, files[0], as_json=as_json)
        return
    if as_json:
        pairs = zip(shares, files, strict=True)
        print_json({"shares": [{**shape.model_dump(mode="json"), "files": written} for shape, written in pairs]})
        return
    for shape, written in zip(shares, files, strict=True):
        print_diagnosis(shape, lines(shape), shape.findings, written, as_json=False)


def fixture(
    of_what: Annotated[
        str, argument("Repeats at one point right after fixturing, or a part.", metavar="FILE.csv|SERIAL")
    ],
    of: Of,
    page: Page,
    repeats_to_um: Annotated[
        float | None, option("Repeatability of one reading.  [default: as stated]", callback=positive)
    ] = None,
    limit_um: Annotated[float | None, option("Largest variation.  [default: no limit]", callback=positive)] = None,
    output: Output = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Show whether part, tool probe and part probe are held.

    Spread, drift and step of repeats. Exit status 1 if not.
    """
    from trueloop.jobs.diagnose.shaped import fixture_of_file, fixture_of_part, limits_of
    from trueloop.jobs.store.opened import open_store
    from trueloop.report.diagnosis.lines import fixture_lines
    from trueloop.report.diagnosis.page_part import fixture_page
    from trueloop.report.markup import write_page

    repeats = limits_of(repeats_to_um, limit_um)
    if of_what.lower().endswith((".csv", ".txt")):
        found = fixture_of_file(Path(of_what), repeats)
    else:
        found = fixture_of_part(open_store(db), of_what, of.asked(None), repeats)
    files = write_page(found, "fixture", fixture_page, output, page.language, page.unit)
    print_diagnosis(found, fixture_lines(found), found.findings, files, as_json=as_json)
    if not all(fixturing.stable for fixturing in found.fixturings):
        raise typer.Exit(ExitStatus.FINDINGS)


def machine(
    model: ModelOption,
    page: Page,
    part_type: Types = None,
    element: Element = None,
    output: Output = None,
    accept: AcceptRefused = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Name the axis errors that the machine's model has wrong.

    As sets, with what would divide each set.
    """
    from trueloop.jobs.diagnose.shaped import machine as diagnosed_machine
    from trueloop.jobs.store.opened import open_store
    from trueloop.report.diagnosis.lines import machine_lines
    from trueloop.report.diagnosis.page_machine import machine_page
    from trueloop.report.markup import write_page

    with busy("diagnosing"):
        found = diagnosed_machine(open_store(db), model, part_type or (), elements_of(element), accept or ())
        files = write_page(found, "machine", machine_page, output, page.language, page.unit)
    print_diagnosis(found, machine_lines(found), found.findings, files, as_json=as_json)


def part(
    serial: Annotated[str, argument("Serial number of the part.", metavar="SERIAL")],
    of: Of,
    page: Page,
    output: Output = None,
    accept: AcceptRefused = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Show the errors of one part and their likely causes.

    Errors of its features by device, components at its points.
    """
    from trueloop.jobs.diagnose import seen_series
    from trueloop.jobs.store.opened import open_store
    from trueloop.report.diagnosis.lines import part_lines
    from trueloop.report.diagnosis.page_part import part_page

    with busy("diagnosing"):
        found = seen_series.part_causes(open_store(db), serial, of.asked(accept))
        files = _written(found, "part", part_page, output, page)
    _print_shares(found, part_lines, files, as_json=as_json)


def series(
    of: Of, page: Page, output: Output = None, accept: AcceptRefused = None, db: Db = None, as_json: AsJson = False
) -> None:
    """Name what makes the parts of a type wrong.

    Tool, probe, set-up, deflection, chatter, or the machine.
    """
    from trueloop.jobs.diagnose import seen_series
    from trueloop.jobs.store.opened import open_store
    from trueloop.report.diagnosis.lines import series_lines
    from trueloop.report.diagnosis.page_part import series_page

    with busy("diagnosing"):
        found = seen_series.series_causes(open_store(db), of.asked(accept))
        files = _written(found, "series", series_page, output, page)
    _print_shares(found, series_lines, files, as_json=as_json)


def refine(
    model: ModelOption,
    errors: Annotated[str, option("Which errors are to be updated; auto: those found.", metavar="EXX,…|auto")],
    out: Annotated[Path, option("Folder of the offered model and the page.", "--output", "-o", metavar="DIR")],
    page: Page,
    share: Annotated[float, option("Part of the change that is made.", min=0.05, max=1.0)] = 1.0,
    part_type: Types = None,
    element: Element = None,
    accept: AcceptRefused = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Refine a machine's model by what it left on parts.

    Parts left out judge it. It is offered, not in force. `trueloop machine accept` puts it in force.
    """
    from trueloop.jobs.diagnose.shaped import Refining, refined
    from trueloop.jobs.store.opened import open_store
    from trueloop.report.diagnosis.lines import machine_lines
    from trueloop.report.texts.texts import Texts

    names = tuple(name.strip() for name in errors.split(",") if name.strip())
    asked = Refining(names, tuple(part_type or ()), tuple(elements_of(element).items()), share)
    with busy("refining"):
        done = refined(open_store(db), model, asked, out, Texts(page.language, page.unit), accept or ())
    print_diagnosis(done.shape, machine_lines(done.shape), done.shape.findings, list(done.files), as_json=as_json)
    if done.kept and not as_json:
        typer.echo(done.kept)


def standard(
    file: Annotated[Path, argument("Calibrated sizes, each with its uncertainty.", metavar="FILE")],
    serial: Annotated[str, option("Serial number of the standard part.")],
    part_type: Annotated[str, option("Part type whose series it is probed among.", "--type", "-t")],
    by: Annotated[str, option("Who calibrated it.")] = "",
    unit: Annotated[Literal["mm", "inch"] | None, option("Unit of its lengths.  [default: as it states]")] = None,
    mapping: Annotated[Path | None, option("TOML file that states what columns and names mean.")] = None,
    supersede: Supersede = False,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Keep a calibrated part, to check probe and machine by.

    Its inspections never count as cuts.
    """
    from trueloop.formats.inspections.measured_file import StatedFacts
    from trueloop.jobs.diagnose.records import keep_standard, standard_of
    from trueloop.jobs.store.opened import open_store

    named = standard_of(part_type, serial)
    kept = keep_standard(open_store(db), file, named, StatedFacts(unit, mapping), by, supersede=supersede)
    print_findings(kept.findings)
    if as_json:
        print_json(kept_as_dict(kept))
    else:
        typer.echo(kept.words)


app = Group("Causes of part errors: tool, probe, set-up or machine.")
app.add_all(part, series, fixture, machine, refine, standard)
