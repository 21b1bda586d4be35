"""The manual that came with the package, served to this machine alone by the standard library."""

from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from typing import Final
from urllib.parse import quote

from trueloop.errors import Code

HOST: Final = "127.0.0.1"
POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'"
)
_PICTURE_POLICY: Final = "default-src 'none'; style-src 'unsafe-inline'; sandbox"
"""Of a drawing: its colours for light and dark stand in it."""
_TEXTS: Final = dict.fromkeys((".nc", ".ngc", ".toml", ".csv", ".md", ".py"), "text/plain; charset=utf-8")


def folder() -> Path:
    """Returns the manual's folder in the package."""
    return Path(str(files("trueloop"))) / "manual"


def require_built(place: Path) -> Path:
    """Returns the folder, which holds the manual. Raises SRV-MANUAL."""
    if not (place / "index.html").is_file():
        raise Code.SRV_MANUAL.refusal(
            f"the manual is not in '{place}'",
            hint="install trueloop from a wheel, which holds it, or build it in a clone: make docs",
        )
    return place


def listening(place: Path, port: int) -> ThreadingHTTPServer:
    """Opens a server of that folder; 0 is any free port. Raises SRV-ADDRESS."""
    try:
        return ThreadingHTTPServer((HOST, port), partial(_Manual, directory=str(place)))
    except OSError as wrong:
        raise Code.SRV_ADDRESS.refusal(
            f"the manual cannot be served at port {port}: {wrong.strerror or wrong}",
            hint="leave --port out: a free one is taken",
            values={"host": HOST, "port": float(port)},
        ) from wrong


def address(server: ThreadingHTTPServer, words: str) -> str:
    """Returns the address of the manual, or of its search for the words."""
    start = f"http://{HOST}:{server.server_port}/"
    return f"{start}search.html?q={quote(words)}" if words else start


class _Manual(SimpleHTTPRequestHandler):
    """Files by their names. Nothing is logged, no folder is listed."""

    extensions_map = SimpleHTTPRequestHandler.extensions_map | _TEXTS | {".html": "text/html; charset=utf-8"}

    def end_headers(self) -> None:
        """Adds the headers by which what a page may load comes from here alone."""
        picture = self.path.partition("?")[0].endswith(".svg")
        self.send_header("Content-Security-Policy", _PICTURE_POLICY if picture else POLICY)
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Cache-Control", "no-cache")
        super().end_headers()

    def list_directory(self, path: object) -> None:
        """Answers 404: a folder is not a page."""
        self.send_error(404)

    def log_message(self, format: str, *args: object) -> None:
        """Logs nothing: the command has printed where the manual is."""
