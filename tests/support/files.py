"""Text as a file, for readers of files."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

Read = TypeVar("Read")


def read_as_file(text: str, read: Callable[[Path], Read], name: str = "given.txt") -> Read:
    """What a reader makes of a file that holds the text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_text(text)
        return read(path)
