"""What came of sending a program, and what holds for every way of sending one."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeAlias

from trueloop.controllers.links.compare import Difference
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, TrueloopError
from trueloop.formats.outputs import write_all
from trueloop.jobs.links.opened import Opened

Replace: TypeAlias = bool | bytes
"""Whether another program of that name may be replaced; bytes: this one may, and no other."""


@dataclass(frozen=True)
class Sent:
    """What was done: hashes of what was sent and of what the control holds now, and where the program before it is.

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
    return TrueloopError(Code.LNK_RUNNING, f"{name!r} {state} at {opened.link.where}", hint=hint, values={"name": name})


def _unknown(which: str, name: str, opened: Opened) -> TrueloopError:
    return TrueloopError(
        Code.LNK_RUNNING,
        f"{opened.link.where} does not say which program runs: {which} may",
        hint="look at the control",
        override="--not-running",
        values={"name": name},
    )


def kept_first(opened: Opened, name: str, before: bytes) -> Path:
    """One file for each program that was replaced, by time and hash."""
    at = datetime.now(UTC).strftime("%Y%m%dT%H%M%S")
    (path,) = write_all(opened.replaced / opened.name, [(f"{name}.{at}.{sha256_of(before)[:8]}", before)])
    return path


def require_unchanged(before: bytes | None, now: bytes | None, name: str, opened: Opened) -> None:
    """Raises LNK-CHANGED where the control has now another program of that name, or another offset, than before."""
    if now != before:
        raise TrueloopError(
            Code.LNK_CHANGED,
            f"{name!r} at {opened.link.where} was {'written' if before is None else 'changed'} while this one was sent",
            hint="compare it, then send again",
            values={"name": name},
        )


def require_same(name: str, found: list[Difference], state: str) -> None:
    """Raises LNK-DIFFERS where there are differences; `state`: what the control holds now."""
    if not found:
        return
    first = found[0]
    lines = [one.line or one.other_line or 0 for one in found]
    raise TrueloopError(
        Code.LNK_DIFFERS,
        f"{name!r} came back otherwise in {len(found)} lines, the first {lines[0]}: {_said(first)}; {state}; lines "
        f"{', '.join(map(str, lines))}",
        hint="if this control always changes that (capitals, blanks, line ends), say so in `passes` of its settings",
        values={"name": name, "lines": lines},
    )


def _said(one: Difference) -> str:
    """The first word that differs, or the line where it is no word."""
    if not one.words:
        return f"sent {one.before!r}, came back {one.after!r}"
    word = one.words[0]
    return f"{f'{one.block} ' if one.block else ''}{word.what} sent {word.before!r}, came back {word.after!r}"
