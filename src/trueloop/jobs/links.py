"""Programs to and from controls, and what of it is kept."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from decimal import Decimal
from pathlib import Path
from typing import Final, Literal, TypeAlias

from trueloop.controllers.links.compare import Change, Difference, differences, in_words
from trueloop.controllers.links.focas import TABLE, Focas
from trueloop.controllers.links.folder import Folder, Link, checked_name, linuxcnc_busy, linuxcnc_reads, named_in
from trueloop.controllers.links.ftp import Ftp
from trueloop.controllers.links.line import Line, framed
from trueloop.controllers.linuxcnc.realtime.signals.component import linuxcnc_module
from trueloop.described import filled_from
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, TrueloopError
from trueloop.factory.carry_out import carry_out
from trueloop.factory.decisions.plan import not_released
from trueloop.factory.requests import By, RecordTransfer, Role
from trueloop.factory.shown.programs import program_row
from trueloop.factory.shown.records import known_of
from trueloop.formats.links_toml import AnyLink, FocasTable, FolderTable, LinuxCncTable, SerialTable, read_link
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.tool_tables.known import NewTable, new_table, tool_table_of
from trueloop.formats.tables.tool_tables.tool_table import Number, ToolRow, ToolTable, Unit
from trueloop.jobs.turned.outputs import offset_of
from trueloop.jobs.user import user_name
from trueloop.nc.program.guess import likeliest_dialect
from trueloop.storage.store import Store

Key: TypeAlias = tuple[int, int, str, int]
"""Tool, edge, kind, and which of the rows of these."""


def differing_rows(name: str, first: bytes, second: bytes, unit: Unit | None) -> list[Difference]:
    """Returns the rows whose numbers differ, or that one table alone has. Raises OFS errors for no tool table."""
    one, other = (tool_table_of(Path(name), content, unit) for content in (first, second))
    if one.unit != other.unit:
        return [Difference(None, f"unit {one.unit}", None, f"unit {other.unit}")]
    rows, others = _keyed(one), _keyed(other)
    keys = [*rows, *(key for key in others if key not in rows)]
    pairs = [(rows.get(key), others.get(key)) for key in keys]
    return [Difference(*_place(one, a), *_place(other, b)) for a, b in pairs if _row_text(a) != _row_text(b)]


def _keyed(table: ToolTable) -> dict[Key, ToolRow]:
    keyed = dict[Key, ToolRow]()
    for row in table.rows:
        of = (row.tool, row.edge, row.kind)
        keyed[*of, sum(key[:3] == of for key in keyed)] = row
    return keyed


def _row_text(row: ToolRow | None) -> object:
    if row is None:
        return None
    return [*map(_value, (row.x, row.z, row.nose)), row.tip, dict(row.others)]


def _value(number: Number | None) -> object:
    """A number that stands in no row yet is none."""
    return None if number is None or number.start == number.end else number.value


def _place(table: ToolTable, row: ToolRow | None) -> tuple[int, str] | tuple[None, None]:
    return (None, None) if row is None else (row.line, table.text.split("\n")[row.line - 1].rstrip("\r"))


JUDGED: Final = 100_000
"""Bytes of a program by which its dialect is found."""


@dataclass(frozen=True)
class Opened:
    """A link, what its control may change in a program, and where what is replaced there is written.

    `tool_table`: which of its programs is the control's tool table; `table_unit`: of one that does not say it;
    `dialect` of its programs, empty: the one that they look most like.
    """

    name: str
    link: Link | Line
    passes: frozenset[Change]
    replaced: Path
    tool_table: str = ""
    table_unit: Unit | None = None
    dialect: str = ""

    def differences(self, name: str, content: bytes, at_control: bytes) -> list[Difference]:
        """Returns the lines and words that differ, other than by what this control, or its line, always changes.

        A tool table that a line or FOCAS carries is made of the numbers that the control took: these are compared.
        """
        if isinstance(self.link, Line | Focas) and name == self.tool_table:
            return differing_rows(name, content, at_control, self.table_unit)
        passes = self.passes
        if isinstance(self.link, Line | Focas):
            content, at_control, passes = framed(content), framed(at_control), passes | {Change.LINE_ENDS}
        found = differences(content, at_control, passes)
        return in_words(found, self.dialect or likeliest_dialect(content[:JUDGED]), passes) if found else []


def opened(settings: Path, name: str, tell: Callable[[str], None] = print) -> Opened:
    """Opens the link; connects to nothing yet. `tell` gets what a person has to do at the control. Raises LNK-FILE."""
    table = read_link(settings, name)
    passes = frozenset(Change(name) for name in table.passes)
    link, replaced = link_of(table, settings.parent, tell), settings.parent / table.replaced
    return filled_from(Opened, table, name=name, link=link, passes=passes, replaced=replaced)


def link_of(table: AnyLink, beside: Path, tell: Callable[[str], None]) -> Link | Line:
    """Makes the link of a table; relative names count from `beside`. Connects to nothing."""
    if isinstance(table, FolderTable):
        return Folder(beside / table.folder, named_in(beside / table.running_file) if table.running_file else None)
    if isinstance(table, LinuxCncTable):
        own = beside / table.ini, lambda: linuxcnc_module("linuxcnc")
        reads = linuxcnc_reads(*own, table.tool_table) if table.tool_table else None
        return Folder(beside / table.folder, linuxcnc_busy(*own), reads)
    if isinstance(table, SerialTable):
        return filled_from(Line, table, tell=tell)
    if isinstance(table, FocasTable):
        increment = None if table.increment is None else Decimal(str(table.increment))
        library = beside / table.library
        return filled_from(Focas, table, library=library, increment=increment, unit=table.table_unit)
    address = (table.host, table.port, table.user, table.password_env, table.folder)
    return Ftp(*address, table.tls, table.timeout_s, beside / table.authority if table.authority else None)


Replace: TypeAlias = bool | bytes
"""Permission to replace another program of that name; bytes: only this program."""


@dataclass(frozen=True)
class Sent:
    """The result: hashes of what was sent and of what the control holds now, and where the program before it is.

    `written`: whether anything was; False where the control had this program already. `kept`: None where the control
    had no program of that name.
    """

    name: str
    sent_sha256: str
    read_back_sha256: str
    written: bool
    kept: Path | None = None


def require_idle(name: str, opened: Opened, not_running: bool) -> None:
    """Raises LNK-RUNNING for a program that runs, is loaded, or may be; for the tool table where any program runs."""
    is_table, busy = name == opened.tool_table, opened.link.busy()
    if busy is None:
        if not not_running:
            raise _unknown("one" if is_table else repr(name), name, opened)
        return
    for running in busy.runs:
        if is_table or _same(running, name):
            what = "tool table is not written" if is_table else "program is not replaced"
            raise _running(running, "runs", f"wait for its end: a {what} meanwhile", opened)
    for loaded in busy.loaded:
        if _same(loaded, name):
            raise _running(loaded, "is loaded", "load another one there first: it would cut what it has read", opened)


def _same(path: str, name: str) -> bool:
    return _name(path).upper() == name.upper()


def _name(path: str) -> str:
    return path.replace("\\", "/").rpartition("/")[2]


def _running(path: str, state: str, hint: str, opened: Opened) -> TrueloopError:
    name = _name(path)
    return Code.LNK_RUNNING.refusal(f"{name!r} {state} at {opened.link.where}", hint=hint, values={"name": name})


def _unknown(which: str, name: str, opened: Opened) -> TrueloopError:
    return Code.LNK_RUNNING.refusal(
        f"{opened.link.where} does not say which program runs: {which} may",
        hint="look at the control",
        override="--not-running",
        values={"name": name},
    )


def kept_first(opened: Opened, name: str, before: bytes) -> Path:
    """Writes one file for each program that was replaced, by time and hash."""
    at = datetime.now(UTC).strftime("%Y%m%dT%H%M%S")
    (path,) = write_all(opened.replaced / opened.name, [(f"{name}.{at}.{sha256_of(before)[:8]}", before)])
    return path


def require_unchanged(before: bytes | None, now: bytes | None, name: str, opened: Opened) -> None:
    """Raises LNK-CHANGED where the control has now another program of that name, or another offset, than before."""
    if now != before:
        raise Code.LNK_CHANGED.refusal(
            f"{name!r} at {opened.link.where} was {'written' if before is None else 'changed'} while this one was sent",
            hint="compare it, then send again",
            values={"name": name},
        )


def require_same(name: str, found: list[Difference], state: str) -> None:
    """Raises LNK-DIFFERS where there are differences; `state`: what the control holds now."""
    if not found:
        return
    first = found[0]
    lines = [difference.line or difference.other_line or 0 for difference in found]
    raise Code.LNK_DIFFERS.refusal(
        f"{name!r} came back otherwise in {len(found)} lines, the first {lines[0]}: {_line_of(first)}; {state}; lines "
        f"{', '.join(map(str, lines))}",
        hint="if this control always changes that (capitals, blanks, line ends), state so by `passes` in "
        "the link's table",
        values={"name": name, "lines": lines},
    )


def _line_of(one: Difference) -> str:
    """The first word that differs, or the line where it is not a word."""
    if not one.words:
        return f"sent {one.before!r}, came back {one.after!r}"
    word = one.words[0]
    return f"{f'{one.block} ' if one.block else ''}{word.what} sent {word.before!r}, came back {word.after!r}"


def send_by_line(
    opened: Opened, line: Line, content: bytes, name: str, replace: Replace, *, not_running: bool = False
) -> Sent:
    """Sends, has it put out again, and compares. With `replace` the control's program of that name is fetched first.

    Without it the control itself has to refuse a number that it has already. What `replace` holds was fetched already.
    Raises LNK-NAME, LNK-LINE, LNK-CODE, LNK-RUNNING, LNK-DIFFERS, and OUT errors.
    """
    name, before = checked_name(name), None
    if replace is not False:
        require_idle(name, opened, not_running)
        before = line.read(name) if replace is True else replace
        if not opened.differences(name, content, before):
            return Sent(name, sha256_of(content), sha256_of(before), written=False)
    kept = None if before is None else kept_first(opened, name, before)
    line.send(name, content)
    back = line.read(name)
    require_same(name, opened.differences(name, content, back), "the control holds it: delete it there")
    return Sent(name, sha256_of(content), sha256_of(back), written=True, kept=kept)


def drip(opened: Opened, content: bytes, name: str) -> None:
    """Feeds a program to a control that cuts as it comes; it cannot come back. Raises LNK-LINE, LNK-CODE, LNK-NAME."""
    if not isinstance(opened.link, Line):
        raise Code.LNK_NAME.refusal(
            f"{name!r} cannot be fed while it is cut: {opened.link.where} takes whole programs",
            hint="send it without --drip",
            values={"name": name},
        )
    opened.link.feed(checked_name(name), content)


def send_by_numbers(
    opened: Opened, control: Focas, content: bytes, name: str, replace: Replace, *, not_running: bool = False
) -> Sent:
    """Raises LNK-EXISTS without `replace`, LNK-RUNNING, LNK-CHANGED, LNK-REACH, LNK-DIFFERS, OFS and OUT errors."""
    before = control.read(name)
    if isinstance(replace, bytes):
        require_unchanged(replace, before, name, opened)
    if not opened.differences(name, content, before):
        return Sent(name, sha256_of(content), sha256_of(before), written=False)
    if replace is False:
        raise Code.LNK_EXISTS.refusal(
            f"{opened.link.where} has other offsets",
            hint="`trueloop link compare` shows where they differ",
            override="--replace",
            values={"name": name},
        )
    require_idle(name, opened, not_running)
    kept = kept_first(opened, name, before)
    control.write_table(content)
    back = control.read(name)
    require_same(name, opened.differences(name, content, back), "the control holds it: see its page of offsets")
    return Sent(name, sha256_of(content), sha256_of(back), written=True, kept=kept)


def send(opened: Opened, content: bytes, name: str, *, replace: Replace = False, not_running: bool = False) -> Sent:
    """Sends a program, reads it back, and gives it its name; what it replaces is written to a file first.

    `replace` allows that another program of that name is replaced, or that one alone; `not_running` is the user's word
    that it does not run, for links that cannot know. Raises LNK-NAME, LNK-REACH, LNK-EXISTS, LNK-RUNNING, LNK-CHANGED
    where somebody changed it meanwhile, LNK-DIFFERS, and OUT errors. Up to the last step the control's own program
    stands unchanged.
    """
    if isinstance(opened.link, Line):
        return send_by_line(opened, opened.link, content, name, replace, not_running=not_running)
    if isinstance(opened.link, Focas) and name == TABLE:
        return send_by_numbers(opened, opened.link, content, name, replace, not_running=not_running)
    link, name = opened.link, checked_name(name)
    before = _there(link, name)
    if isinstance(replace, bytes):
        require_unchanged(replace, before, name, opened)
    if before is not None and not opened.differences(name, content, before):
        return Sent(name, sha256_of(content), sha256_of(before), written=False)
    if before is not None:
        _require_may_be_replaced(name, opened, replace, not_running)
    kept = None if before is None else kept_first(opened, name, before)
    aside = _sent_aside(opened, link, name, content)
    try:
        require_unchanged(before, _there(link, name), name, opened)
        if before is not None:
            require_idle(name, opened, not_running)
        link.put_in_place(aside, name)
    except BaseException:
        link.remove_aside(aside)
        raise
    back = link.read(name)
    require_same(name, opened.differences(name, content, back), "the control holds it under its own name")
    return Sent(name, sha256_of(content), sha256_of(back), written=True, kept=kept)


def _there(link: Link, name: str) -> bytes | None:
    """Returns the control's program of that name in any capitals: some controls know no small letters."""
    names = [program.name for program in link.listed() if program.name.upper() == name.upper()]
    if name in names:
        return link.read(name)
    if names:
        raise Code.LNK_EXISTS.refusal(
            f"{link.where} has {names[0]!r}, which differs from {name!r} in capitals only",
            hint=f"send it as {names[0]!r}, or under another name",
            values={"name": names[0]},
        )
    return None


def _require_may_be_replaced(name: str, opened: Opened, replace: Replace, not_running: bool) -> None:
    if replace is False:
        raise Code.LNK_EXISTS.refusal(
            f"{opened.link.where} has another program {name!r}",
            hint="`trueloop link compare` shows where they differ",
            override="--replace",
            values={"name": name},
        )
    require_idle(name, opened, not_running)


def _sent_aside(opened: Opened, link: Link, name: str, content: bytes) -> str:
    aside = link.write_aside(name, content)
    try:
        found = opened.differences(name, content, link.read(aside))
        require_same(name, found, "the control's own program of that name is unchanged")
    except BaseException:
        link.remove_aside(aside)
        raise
    return aside


@dataclass(frozen=True)
class AtControl:
    """A tool table as it was in force, the one that took its place, by which correction, and how it was sent."""

    record_id: str
    table: ToolTable
    new: NewTable
    sent: Sent


def with_table(opened: Opened, table: str | None, unit: Unit | None) -> Opened:
    """Returns the link with another name or unit of its tool table than its settings have. Raises LNK-NAME."""
    name = table or opened.tool_table
    if not name:
        raise Code.LNK_NAME.refusal(
            f"nothing says which program at {opened.link.where} is the tool table",
            hint="name it with --table, or as `tool_table` in the link's table",
            values={"name": name},
        )
    return replace(opened, tool_table=checked_name(name), table_unit=unit or opened.table_unit)


def fetched_table(opened: Opened) -> ToolTable:
    """Fetches the control's tool table in force. Raises LNK and OFS errors."""
    content = opened.link.read(opened.tool_table)
    return tool_table_of(Path(opened.tool_table), content, opened.table_unit)


def apply_at(opened: Opened, correction: Path, *, not_running: bool = False) -> AtControl:
    """Writes the control's tool table with the offset of a correction changed; the one before it is kept first.

    Only the table that was read is replaced, and only while no program runs (`not_running`: the user's word for
    links that cannot know). Raises what `send` and `apply_offset` raise.
    """
    record, offset = offset_of(correction)
    require_idle(opened.tool_table, opened, not_running)
    read = fetched_table(opened)
    new = new_table(read, offset, record.id)
    before = read.text.encode("latin-1")
    sent = send(opened, new.content, opened.tool_table, replace=before, not_running=not_running)
    return AtControl(record.id, read, new, sent)


@dataclass(frozen=True)
class Recorder:
    """The store that keeps them, and the control by its link's name."""

    store: Store
    control: str

    def fetched(self, name: str, content: bytes) -> None:
        """Records that a program came from the control."""
        sha = sha256_of(content)
        self._keep(name, "from", sha, "", sha, "fetched")

    def compared(self, name: str, content: bytes, at_control: bytes, differences: Sequence[Difference]) -> None:
        """Records that a program of the control was compared with a file."""
        outcome = f"differs: {'; '.join(map(_said, differences))}" if differences else "the same"
        self._keep(name, "from", sha256_of(content), "", sha256_of(at_control), outcome)

    def sent(
        self, opened: Opened, content: bytes, name: str, *, replace: Replace = False, not_running: bool = False
    ) -> Sent:
        """Sends a released program and keeps what came of it, a refusal too. Raises FAC-RELEASE, FAC-UNKNOWN before."""
        sha = sha256_of(content)
        with known_of(self.store) as known:
            if not program_row(known, sha).released:
                raise not_released(sha)
        try:
            done = send(opened, content, name, replace=replace, not_running=not_running)
        except TrueloopError as error:
            self._keep(name, "to", sha, sha, "", f"{error.code.value}: {error.message}")
            raise
        self._keep(name, "to", sha, sha, done.read_back_sha256, "read back" if done.written else "there already")
        return done

    def _keep(
        self, name: str, direction: Literal["to", "from"], program: str, sent: str, back: str, outcome: str
    ) -> None:
        request = RecordTransfer(
            control=self.control,
            program_sha256=program,
            name=name,
            direction=direction,
            sent_sha256=sent,
            read_back_sha256=back,
            outcome=outcome,
        )
        carry_out(self.store, request, By(user_name(), Role.OPERATOR), datetime.now(UTC))


def _said(difference: Difference) -> str:
    words = ", ".join(f"{word.what} {word.before!r} {word.after!r}" for word in difference.words)
    return f"line {difference.line or difference.other_line} {words or f'{difference.before!r} {difference.after!r}'}"
