"""Sending a program over a serial line: what it replaces comes out first, and what was sent comes back."""

from trueloop.controllers.links.line.line import Line
from trueloop.controllers.links.link import checked_name
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.links.opened import Opened
from trueloop.jobs.links.sent import Replace, Sent, kept_first, require_idle, require_same


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
    """Feeds a program to a control that cuts as it comes, and holds the line while it cuts. It cannot come back.

    Raises LNK-LINE, LNK-CODE, and LNK-NAME for a link that is no serial line.
    """
    if not isinstance(opened.link, Line):
        raise TrueloopError(
            Code.LNK_NAME,
            f"{name!r} cannot be fed while it is cut: {opened.link.where} takes whole programs",
            hint="send it without --drip",
            values={"name": name},
        )
    opened.link.feed(checked_name(name), content)
