"""Sending a program to a control: nothing takes its name there before it came back as it was sent."""

from trueloop.controllers.links.focas.focas import TABLE, Focas
from trueloop.controllers.links.line.line import Line
from trueloop.controllers.links.link import Link, checked_name
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.links.by_line import send_by_line
from trueloop.jobs.links.by_numbers import send_by_numbers
from trueloop.jobs.links.opened import Opened
from trueloop.jobs.links.sent import Replace, Sent, kept_first, require_idle, require_same, require_unchanged


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
    """What the control has of that name, whatever its capitals: some controls know no small letters."""
    names = [one.name for one in link.listed() if one.name.upper() == name.upper()]
    if name in names:
        return link.read(name)
    if names:
        raise TrueloopError(
            Code.LNK_EXISTS,
            f"{link.where} has {names[0]!r}, which differs from {name!r} in capitals only",
            hint=f"send it as {names[0]!r}, or under another name",
            values={"name": names[0]},
        )
    return None


def _require_may_be_replaced(name: str, opened: Opened, replace: Replace, not_running: bool) -> None:
    if replace is False:
        raise TrueloopError(
            Code.LNK_EXISTS,
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
