"""Writing the offsets of a control that keeps them as numbers: those in force are kept first, and read back after."""

from trueloop.controllers.links.focas.focas import Focas
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.links.opened import Opened
from trueloop.jobs.links.sent import Replace, Sent, kept_first, require_idle, require_same, require_unchanged


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
        raise TrueloopError(
            Code.LNK_EXISTS,
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
