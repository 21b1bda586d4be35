"""Writes web/src/api/shapes.ts, the shapes of the service's answers in TypeScript: python -m scripts.web_shapes.

openapi-typescript makes them from the service's OpenAPI document; `make web` runs it before it builds the pages.
"""

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any, Final, cast

from trueloop.server.app import create_app
from trueloop.server.settings import Settings
from trueloop.storage.store import Store

WEB: Final = Path(__file__).parent.parent / "web"
SHAPES: Final = WEB / "src" / "api" / "shapes.ts"


def openapi() -> dict[str, Any]:
    """Returns the OpenAPI document of the service; no store is opened for it."""
    return create_app(cast(Store, None), Settings()).openapi()


def write() -> None:
    """Writes the shapes; a file that is equal already keeps its time, so that nothing is built anew."""
    with tempfile.TemporaryDirectory() as folder:
        document = Path(folder) / "openapi.json"
        document.write_text(json.dumps(openapi(), sort_keys=True), encoding="utf-8")
        tool = WEB / "node_modules" / ".bin" / "openapi-typescript"
        made = Path(folder) / "shapes.ts"
        subprocess.run([tool, document, "-o", made], check=True, stdout=subprocess.DEVNULL, cwd=WEB, timeout=120)
        if not SHAPES.exists() or SHAPES.read_bytes() != made.read_bytes():
            SHAPES.write_bytes(made.read_bytes())


if __name__ == "__main__":
    write()
