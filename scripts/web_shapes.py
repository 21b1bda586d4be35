"""The shapes of the service's answers for its pages, in TypeScript: python -m scripts.web_shapes [FILE].

They are made by openapi-typescript from what the service says of itself, and kept beside the pages; a test compares.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Final, cast

from trueloop.server.app import create_app
from trueloop.server.settings import Settings
from trueloop.storage.store import Store

WEB: Final = Path(__file__).parent.parent / "web"
SHAPES: Final = WEB / "src" / "api" / "shapes.ts"


def openapi() -> dict[str, Any]:
    """What the service says of itself; no store is opened for it."""
    return create_app(cast(Store, None), Settings()).openapi()


def write(to: Path) -> None:
    """Writes the shapes to a file. The tool is the one that `make web` installs."""
    with tempfile.TemporaryDirectory() as folder:
        document = Path(folder) / "openapi.json"
        document.write_text(json.dumps(openapi(), sort_keys=True), encoding="utf-8")
        tool = WEB / "node_modules" / ".bin" / "openapi-typescript"
        subprocess.run([tool, document, "-o", to], check=True, stdout=subprocess.DEVNULL, cwd=WEB, timeout=120)


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else SHAPES)
