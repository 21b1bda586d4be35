"""The pages that came with the package: files by their names, and index.html for every address that is not a file."""

import secrets
from importlib.resources import files
from pathlib import Path
from typing import Final

from fastapi import FastAPI, Request
from fastapi.responses import FileResponse, HTMLResponse, Response

from trueloop.server.etags import reader_of
from trueloop.server.problems import answer_of, nothing
from trueloop.server.settings import Settings
from trueloop.wording import wording

NONCE: Final = "__NONCE__"
"""Stands in index.html wherever the answer's nonce belongs."""
_TYPES: Final = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".json": "application/json",
    ".webmanifest": "application/manifest+json",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".ico": "image/x-icon",
    ".woff2": "font/woff2",
    ".txt": "text/plain; charset=utf-8",
}
_NOT_BUILT: Final = """<!doctype html><html lang="en"><meta charset="utf-8"><title>trueloop</title>
<p>The service runs; its pages were not built. In a clone of trueloop: <code>make web</code>.
The interface for programs is at <code>/api/v1</code>."""


def policy_of(nonce: str) -> str:
    """Returns the policy of the pages: scripts from here alone, styles from here and those of this answer."""
    return (
        "default-src 'none'; script-src 'self'; worker-src 'self'; connect-src 'self'; img-src 'self' data:; "
        f"font-src 'self'; manifest-src 'self'; frame-src 'self'; style-src 'self' 'nonce-{nonce}'; "
        "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
    )


FILE_POLICY: Final = (
    "default-src 'none'; script-src 'self'; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'"
)
"""Of a file: a worker, which hears the events for all windows, goes by the policy that its own script came with."""

REPORT_POLICY: Final = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)
"""Of a report: figures need their own scripts and styles, and get no cookie, no store and no network to use them on."""


def report(content: str | bytes) -> Response:
    """Answers with a report, in its own sandbox."""
    headers = {"Content-Security-Policy": REPORT_POLICY, "X-Frame-Options": "SAMEORIGIN"}
    return HTMLResponse(content, headers=headers)


PICTURE_POLICY: Final = "sandbox; default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
"""Of a picture: it has neither scripts nor styles, and opened by itself it may do nothing."""


def picture(svg: str) -> Response:
    """Answers with a picture (SVG)."""
    return Response(svg, media_type="image/svg+xml", headers={"Content-Security-Policy": PICTURE_POLICY})


def folder_of(settings: Settings) -> Path:
    """Returns the folder of the pages."""
    return settings.pages or Path(str(files("trueloop"))) / "pages"


def install(app: FastAPI, settings: Settings) -> None:
    """Adds the pages, after all other addresses."""
    folder = folder_of(settings)
    names = {str(one.relative_to(folder).as_posix()): one for one in folder.rglob("*") if one.is_file()}

    @app.get("/{path:path}", include_in_schema=False)
    def page(path: str, request: Request) -> Response:
        """Answers with a file, by its whole name among those there are: no name is put together to a path."""
        if path.startswith("api/"):
            return answer_of(nothing(wording("address"), f"/{path}"), reader_of(request))
        found = names.get(path)
        if found is not None and path != "index.html":
            lasting = "public, max-age=31536000, immutable" if path.startswith("assets/") else "no-cache"
            media = _TYPES.get(found.suffix, "application/octet-stream")
            return FileResponse(
                found, media_type=media, headers={"Cache-Control": lasting, "Content-Security-Policy": FILE_POLICY}
            )
        if "." in path.rpartition("/")[2]:
            return answer_of(nothing(wording("file"), f"/{path}"), reader_of(request))
        file = names.get("index.html")
        nonce = secrets.token_urlsafe(16)
        text = _NOT_BUILT if file is None else file.read_text(encoding="utf-8").replace(NONCE, nonce)
        return HTMLResponse(text, headers={"Content-Security-Policy": policy_of(nonce)})
