"""The shaft example with readings of a test's own."""

from pathlib import Path
from shutil import copytree

EXAMPLES = Path(__file__).parents[2] / "examples"


def shaft_with(folder: Path, readings: str | bytes, more: str = "", table: str = "gauging") -> Path:
    """The example's job in a folder, with this text of readings; `more` are keys of one of its tables."""
    copytree(EXAMPLES / "shaft", folder, dirs_exist_ok=True)
    content = readings if isinstance(readings, bytes) else readings.encode()
    (folder / "readings.csv").write_bytes(content)
    job = folder / "job.toml"
    text = job.read_text(encoding="utf-8")
    assert f"[{table}]\n" in text and 'folder = "../../out/shaft"' in text
    text = text.replace("../../out/shaft", "out")  # a record of another test beside it would be asked about
    job.write_text(text.replace(f"[{table}]\n", f"[{table}]\n{more}"), encoding="utf-8")
    return job
