"""`trueloop link`: programs at a control, listed, fetched, sent and compared."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.shared_options import UnitOption, argument, option
from trueloop.cli.terminal import AsJson, ExitStatus, Group, print_json, print_lines, print_table

if TYPE_CHECKING:
    from trueloop.controllers.links.folder import ListedProgram
    from trueloop.jobs.links import AtControl, Opened, Recorder

NotRunning = Annotated[bool, option("It does not run: for links that cannot know it.", "--not-running")]

Db = Annotated[str | None, option("Record the transfer in this store.  [default: in none]", "--db", metavar="FILE|URL")]


@dataclass(frozen=True, kw_only=True)
class LinkOf:
    """Selects the control."""

    link: Annotated[str, option("The link's name in the settings.", "--link", "-l")]
    settings: Annotated[Path, option("A TOML file with a table for each link.", metavar="LINKS.toml")] = Path(
        "links.toml"
    )

    def opened(self) -> "Opened":
        """The link; what its user has to know goes to stderr."""
        from trueloop.jobs.links import opened

        found = opened(self.settings, self.link, lambda said: typer.echo(said, err=True))
        if found.link.note:
            typer.echo(f"note: {found.link.note}", err=True)
        return found

    def recorder(self, db: str | None) -> "Recorder | None":
        """Returns the recorder of the transfer, where a store is named."""
        if db is None:
            return None
        from trueloop.jobs.links import Recorder
        from trueloop.jobs.store.opened import open_store

        return Recorder(open_store(db), self.link)


def offsets(
    control: LinkOf,
    correction: Annotated[
        Path | None,
        option(
            "A correction, its record or its job: write the table with its offset.",
            "--apply",
            metavar="JOB.toml|RECORD.json",
        ),
    ] = None,
    table: Annotated[
        str | None, option("The table's name at the control.  [default: the settings' tool_table]", "--table", "-t")
    ] = None,
    unit: UnitOption = None,
    not_running: NotRunning = False,
    as_json: AsJson = False,
) -> None:
    """Show a control's tool table, or write an offset into it.

    The table in force; the offset is that of a correction.
    """
    from trueloop.jobs.links import apply_at, fetched_table, with_table
    from trueloop.report.tool_tables import heading_words, table_as_dict, table_lines

    opened = with_table(control.opened(), table, unit)
    if correction is not None:
        _show(apply_at(opened, correction, not_running=not_running), as_json)
        return
    found = fetched_table(opened)
    if as_json:
        print_json(table_as_dict(found))
        return
    print_lines([heading_words(found), "", *table_lines(found), *(f"- {remark}" for remark in found.remarks)])


def _show(done: "AtControl", as_json: bool) -> None:
    from trueloop.report.tool_tables import change_as_dict, change_words

    sent = done.sent
    kept = None if sent.kept is None else str(sent.kept)
    if as_json:
        change = change_as_dict(done.record_id, done.table, done.new, sent.name)
        hashes = {"sent_sha256": sent.sent_sha256, "read_back_sha256": sent.read_back_sha256}
        print_json(change | hashes | {"kept": kept})
        return
    print_lines([f"Correction {done.record_id}", *change_words(done.table, done.new)])
    typer.echo(f"{sent.name}: read back as it was sent, {sent.read_back_sha256[:16]}; the table before it: {kept}")


app = Group("Programs and tool table at a control: listed, read, sent. DNC: programs are compared as well.")
app.add(offsets)


Name = Annotated[str, argument("The program's name at the control.", metavar="NAME")]


@app.command()
def list_(control: LinkOf, as_json: AsJson = False) -> None:
    """List the programs at a control."""
    there = control.opened().link.listed()
    if as_json:
        print_json({"programs": [_row(program.name, program.size_bytes, program.changed_at) for program in there]})
        return
    print_table(("program", "bytes", "changed"), [_cells(program) for program in there])


def _cells(program: "ListedProgram") -> tuple[str, str, str]:
    changed = "" if program.changed_at is None else f"{program.changed_at.astimezone():%Y-%m-%d %H:%M:%S}"
    return program.name, "" if program.size_bytes is None else str(program.size_bytes), changed


def _row(name: str, size_bytes: int | None, changed_at: object) -> dict[str, object]:
    return {"name": name, "size_bytes": size_bytes, "changed_at": None if changed_at is None else str(changed_at)}


@app.command()
def get(
    name: Name,
    control: LinkOf,
    output: Annotated[Path, option("The file to be written; a new one.", "--output", "-o")],
    db: Db = None,
) -> None:
    """Fetch a program from a control, byte for byte.

    No existing file is overwritten.
    """
    from trueloop.controllers.links.folder import checked_name
    from trueloop.formats.outputs import write_all

    recorder = control.recorder(db)
    content = control.opened().link.read(checked_name(name))
    there = (output,) if output.exists() else ()
    (written,) = write_all(output.parent, [(output.name, content)], there)
    typer.echo(f"written: {written}", err=True)
    if recorder is not None:
        recorder.fetched(name, content)


@app.command()
def put_(
    file: Annotated[Path, argument("The program.", metavar="FILE")],
    control: LinkOf,
    name: Annotated[str | None, option("Its name at the control.  [default: the file's]")] = None,
    replace: Annotated[bool, option("Replace another program of that name.", "--replace")] = False,
    not_running: NotRunning = False,
    drip_feed: Annotated[
        bool, option("Feed it while it is cut, over a serial line: it is not read back.", "--drip")
    ] = False,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Send a program to a control, and read it back.

    The program that it replaces is written to a file first.
    """
    from trueloop.errors import Code
    from trueloop.formats.input_file import read_input
    from trueloop.jobs.links import drip, send

    content = read_input(file, Code.NC_FILE, hint="name the program to be sent")
    if drip_feed:
        drip(control.opened(), content, name or file.name)
        typer.echo(f"{name or file.name}: fed; what is cut as it comes cannot be read back")
        return
    recorder = control.recorder(db)
    sends = send if recorder is None else recorder.sent
    done = sends(control.opened(), content, name or file.name, replace=replace, not_running=not_running)
    if as_json:
        print_json(
            {
                "name": done.name,
                "written": done.written,
                "sent_sha256": done.sent_sha256,
                "read_back_sha256": done.read_back_sha256,
                "kept": None if done.kept is None else str(done.kept),
            }
        )
        return
    what = "read back as it was sent" if done.written else "there already: nothing was written"
    typer.echo(f"{done.name}: {what}, {done.read_back_sha256[:16]}")
    if done.kept is not None:
        typer.echo(f"the program before it: {done.kept}")


@app.command()
def compare(
    file: Annotated[Path, argument("The program as it should be.", metavar="FILE")],
    control: LinkOf,
    name: Annotated[str | None, option("Its name at the control.  [default: the file's]")] = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Compare a file with the program at a control, word by word.

    Exit status 1 where one differs.
    """
    from trueloop.controllers.links.folder import checked_name
    from trueloop.errors import Code
    from trueloop.formats.input_file import read_input
    from trueloop.report.program_diff import HEADINGS, difference_rows, differences_as_dict

    content = read_input(file, Code.NC_FILE, hint="name the program to be compared")
    found = control.opened()
    there = checked_name(name or file.name)
    recorder, at_control = control.recorder(db), found.link.read(there)
    differing = found.differences(there, content, at_control)
    if recorder is not None:
        recorder.compared(there, content, at_control, differing)
    if as_json:
        print_json(differences_as_dict(differing))
    elif differing:
        print_table(HEADINGS, difference_rows(differing))
    else:
        typer.echo(f"the same as at {found.link.where}")
    if differing:
        raise typer.Exit(ExitStatus.FINDINGS)
