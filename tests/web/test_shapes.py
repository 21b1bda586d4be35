"""What the pages know of the service's answers is what the service says."""

from pathlib import Path

from scripts import web_shapes


def test_the_shapes_are_current(tmp_path: Path) -> None:
    """Else: python -m scripts.web_shapes."""
    web_shapes.write(tmp_path / "shapes.ts")
    assert (tmp_path / "shapes.ts").read_text() == web_shapes.SHAPES.read_text()
