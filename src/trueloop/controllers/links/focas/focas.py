"""A Fanuc control by the user's own FOCAS library: its programs by O number, and its offsets as a table of G10."""

from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Final

from trueloop.controllers.links.focas.library import Connection, connected
from trueloop.controllers.links.focas.numbers import checked_text, number_of, renumbered
from trueloop.controllers.links.focas.offsets import offsets_text, write_offsets
from trueloop.controllers.links.focas.transfer import busy, delete, directory, download, upload
from trueloop.controllers.links.link import PART, Busy, Listed, no_such_program
from trueloop.errors import Code, TrueloopError
from trueloop.formats.tables.tool_tables.tool_table import Unit

TABLE: Final = "OFFSETS"
"""What the control's offsets are called among its programs."""


@dataclass(frozen=True)
class Focas:
    """Programs in the folder that is chosen at the control. Each call connects anew.

    `aside`: the number of a program that is there for transfers alone. `increment`: what offsets are counted in, in
    `unit`. Raises LNK-LIBRARY where the library cannot be loaded.
    """

    host: str
    library: Path
    aside: int
    port: int = 8193
    timeout_s: float = 10.0
    increment: Decimal | None = None
    unit: Unit | None = None

    @property
    def where(self) -> str:
        """The address."""
        return f"focas://{self.host}:{self.port}"

    @property
    def note(self) -> str:
        """The protocol knows no password."""
        return f"{self.host}: FOCAS knows no password, anybody on this network can do the same"

    def listed(self) -> list[Listed]:
        """The programs, without the one of transfers."""
        with self._connected() as control:
            return [one for one in directory(control) if number_of(one.name) != self.aside]

    def read(self, name: str) -> bytes:
        """A program, framed; of one sent aside with the number that it is to have. `TABLE`: the offsets."""
        with self._connected() as control:
            if name == TABLE:
                return offsets_text(control, *self._counted())
            if name.endswith(PART):
                return renumbered(upload(control, self.aside), number_of(name.removesuffix(PART)))
            number, there = number_of(name), [one.name for one in directory(control)]
            if name not in there:
                raise no_such_program(name, self.where, there)
            return upload(control, number)

    def write_aside(self, name: str, content: bytes) -> str:
        """Sends it under the number of transfers: the control then says whether it takes it, and has room."""
        text = renumbered(checked_text(content, name), self.aside)
        with self._connected() as control:
            self._removed(control)
            download(control, text)
        return name + PART

    def put_in_place(self, aside: str, name: str) -> None:
        """Deletes the program of that name, and sends the one that was sent aside under it; else that one again."""
        number, text = number_of(name), self.read(aside)
        with self._connected() as control:
            if any(one.name == name for one in directory(control)):
                before = upload(control, number)
                delete(control, number)
                try:
                    download(control, text)
                except BaseException:
                    with suppress(TrueloopError):
                        download(control, before)
                    raise
            else:
                download(control, text)
            self._removed(control)

    def remove_aside(self, aside: str) -> None:
        """What cannot be removed stays under the number of transfers, in whose place the next one comes."""
        with suppress(TrueloopError), self._connected() as control:
            self._removed(control)

    def busy(self) -> Busy | None:
        """What runs."""
        with self._connected() as control:
            return busy(control)

    def write_table(self, content: bytes) -> None:
        """Writes the offsets that differ from those in force; after an error those that were written are put back."""
        increment, unit = self._counted()
        with self._connected() as control:
            write_offsets(control, offsets_text(control, increment, unit), content, increment, unit)

    def _removed(self, control: Connection) -> None:
        if any(number_of(one.name) == self.aside for one in directory(control)):
            delete(control, self.aside)

    def _counted(self) -> tuple[Decimal, Unit]:
        if self.increment is None or self.unit is None:
            raise TrueloopError(
                Code.OFS_UNIT,
                f"{self.where} counts offsets, and nothing says in what: a tenth or ten times as much would be read",
                hint="state `table_unit`, and `increment` (0.001 where the control shows three decimals), for the link",
            )
        return self.increment, self.unit

    def _connected(self) -> AbstractContextManager[Connection]:
        return connected(self.library, self.host, self.port, self.timeout_s)
