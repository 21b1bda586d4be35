"""An FTP server of its own process: `python -m tests.support.ftp_server FOLDER [WAY…]`.

It prints its port. Ways: `no-replacing`: renames nothing onto a file that is there; `capitals`: what is stored is in
capitals; `cut=BYTES`: it dies after so many bytes were sent to it; `tls=PEM`: over TLS alone, with that certificate
and key.
"""

import io
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

USER, PASSWORD = "operator", "secret"


@contextmanager
def ftp_server(folder: Path, *ways: str) -> Iterator[int]:
    """Its port, while the block runs."""
    call = [sys.executable, "-W", "ignore", "-m", "tests.support.ftp_server", str(folder), *ways]
    process = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert line, "the server did not start"
        yield int(line)
    finally:
        process.kill()
        process.wait(timeout=20)
        if process.stdout is not None:
            process.stdout.close()


def _serve(folder: str, ways: list[str]) -> None:
    from pyftpdlib import handlers
    from pyftpdlib.authorizers import DummyAuthorizer
    from pyftpdlib.filesystems import AbstractedFS, FilesystemError
    from pyftpdlib.servers import FTPServer

    given = dict(way.split("=") for way in ways if "=" in way)
    cut, pem = int(given.get("cut", sys.maxsize)), given.get("tls")

    class Files(AbstractedFS):  # type: ignore[misc]
        def rename(self, src: str, dst: str) -> None:
            if "no-replacing" in ways and os.path.exists(dst):  # noqa: PTH110
                raise FilesystemError("there is such a file")
            super().rename(src, dst)

    class Data(handlers.TLS_DTPHandler if pem else handlers.DTPHandler):  # type: ignore[misc]
        def recv(self, size: int) -> bytes:
            piece: bytes = super().recv(size)
            if self.tot_bytes_received + len(piece) >= cut:
                os._exit(1)
            return piece

    class Handler(handlers.TLS_FTPHandler if pem else handlers.FTPHandler):  # type: ignore[misc]
        certfile, tls_control_required, tls_data_required = pem, True, True
        authorizer = DummyAuthorizer()
        abstracted_fs = Files
        dtp_handler = Data

        def on_file_received(self, file: str) -> None:
            if "capitals" in ways:
                path = Path(file)
                path.write_bytes(path.read_bytes().upper())

    Handler.authorizer.add_user(USER, PASSWORD, folder, perm="elradfmw")
    listening = socket.create_server(("127.0.0.1", 0))
    server = FTPServer(listening, Handler)
    print(listening.getsockname()[1], flush=True)
    sys.stdout = io.StringIO()
    server.serve_forever(handle_exit=False)


if __name__ == "__main__":
    _serve(sys.argv[1], sys.argv[2:])
