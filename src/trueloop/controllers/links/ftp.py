"""A control that serves its programs by FTP, or by FTP over TLS."""

import ftplib
import io
import os
import ssl
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop.controllers.links.folder import LARGEST, NAME, PART, Busy, ListedProgram, no_such_program, not_reached
from trueloop.errors import TrueloopError

OLD: Final = ".old" + PART
"""Name of a program while another takes its place, on servers that cannot rename onto an existing file."""
NOT_THERE: Final = "550"
WRONG: Final[tuple[type[Exception], ...]] = (ftplib.Error, OSError, EOFError, UnicodeError, ValueError)


@dataclass(frozen=True)
class Ftp:
    """Programs in a folder of an FTP server. The password is in the environment: settings are copied and sent.

    `authority`: the certificate by which that of the server is judged, in place of those that this computer trusts.

    A call connects anew, waits `timeout_s` for every answer, and ends.
    """

    host: str
    port: int = 21
    user: str = "anonymous"
    password_env: str = ""
    folder: str = ""
    tls: bool = False
    timeout_s: float = 10.0
    authority: Path | None = None

    @property
    def where(self) -> str:
        """Returns the address."""
        return f"ftp{'s' if self.tls else ''}://{self.user}@{self.host}:{self.port}/{self.folder}"

    @property
    def note(self) -> str:
        """Warns that plain FTP is readable on the network; empty with TLS."""
        return "" if self.tls else f"{self.host}: plain FTP, anybody on this network can read programs and password"

    def listed(self) -> list[ListedProgram]:
        """Lists names and sizes in the folder; a program whose exchange was cut off gets its name back."""
        with self._session() as ftp:
            return [
                ListedProgram(name, _size(ftp, name))
                for name in sorted(_brought_back(ftp, self._names(ftp)))
                if NAME.fullmatch(name) and not name.endswith(PART)
            ]

    def read(self, name: str) -> bytes:
        """Reads the program in binary mode: nothing translates its line ends."""
        with self._session() as ftp:
            names = self._names(ftp)
            if name not in names:
                raise no_such_program(name, self.where, sorted(names))
            return self._retrieved(ftp, name)

    def write_aside(self, name: str, content: bytes) -> str:
        """Sends it as `NAME.part`."""
        aside = name + PART
        with self._session() as ftp:
            ftp.storbinary(f"STOR {aside}", io.BytesIO(content))
        return aside

    def put_in_place(self, aside: str, name: str) -> None:
        """Renames. Where the server does not rename onto a file, the old one is set aside, and back if need be."""
        with self._session() as ftp:
            try:
                ftp.rename(aside, name)
            except ftplib.error_perm:
                if name not in self._names(ftp):
                    raise
                _exchange(ftp, aside, name)

    def remove_aside(self, aside: str) -> None:
        """Removes it; what cannot be removed stays, under a name that no transfer takes for a program."""
        with suppress(TrueloopError), self._session() as ftp, suppress(ftplib.Error):
            ftp.delete(aside)

    def busy(self) -> Busy | None:
        """Returns None: FTP does not report what runs."""
        return None

    @contextmanager
    def _session(self) -> Iterator[ftplib.FTP]:
        """Signed in, in the folder. Raises LNK-REACH for all that goes wrong inside."""
        try:
            with self._client() as ftp:
                ftp.connect(self.host, self.port)
                ftp.login(self.user, os.environ.get(self.password_env, "") if self.password_env else "")
                if isinstance(ftp, ftplib.FTP_TLS):
                    ftp.prot_p()
                if self.folder:
                    ftp.cwd(self.folder)
                yield ftp
        except WRONG as error:
            raise not_reached(self.where, error) from error

    def _client(self) -> ftplib.FTP:
        """With TLS the server's certificate and name are checked, before the password is sent."""
        if self.tls:
            return ftplib.FTP_TLS(timeout=self.timeout_s, context=ssl.create_default_context(cafile=self.authority))
        return ftplib.FTP(timeout=self.timeout_s)

    def _names(self, ftp: ftplib.FTP) -> set[str]:
        """Of an empty folder some servers answer 550."""
        try:
            return {one.rpartition("/")[2] for one in ftp.nlst()}
        except ftplib.error_perm as error:
            if str(error).startswith(NOT_THERE):
                return set()
            raise

    def _retrieved(self, ftp: ftplib.FTP, name: str) -> bytes:
        pieces, size = list[bytes](), 0

        def take(piece: bytes) -> None:
            nonlocal size
            size += len(piece)
            if size > LARGEST:
                raise not_reached(self.where, f"{name!r} has more than {LARGEST} bytes")
            pieces.append(piece)

        ftp.retrbinary(f"RETR {name}", take)
        return b"".join(pieces)


def _size(ftp: ftplib.FTP, name: str) -> int | None:
    try:
        ftp.voidcmd("TYPE I")
        return ftp.size(name)
    except ftplib.Error:
        return None


def _brought_back(ftp: ftplib.FTP, names: set[str]) -> set[str]:
    lost = {name.removesuffix(OLD) for name in names if name.endswith(OLD)} - names
    for name in lost:
        ftp.rename(name + OLD, name)
    return names | lost


def _exchange(ftp: ftplib.FTP, aside: str, name: str) -> None:
    old = name + OLD
    with suppress(ftplib.error_perm):
        ftp.delete(old)  # of an exchange that was cut off after its end
    ftp.rename(name, old)
    try:
        ftp.rename(aside, name)
    except ftplib.Error:
        ftp.rename(old, name)
        raise
    with suppress(ftplib.error_perm):
        ftp.delete(old)
