"""The manual, built from docs/ and served to a browser as `trueloop docs` does it."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from trueloop.server import manual


@contextmanager
def served_manual(folder: Path) -> Iterator[str]:
    """Its address."""
    with manual.listening(folder, 0) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        try:
            yield manual.address(server, "")
        finally:
            server.shutdown()
            thread.join(20)
