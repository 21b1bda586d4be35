"""Diagnoses as files: JSON and page."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from trueloop.domain.option import Language, LengthUnit
from trueloop.formats.outputs import write_all
from trueloop.report.shape import Shape
from trueloop.report.texts.texts import Texts

T = TypeVar("T", bound=Shape)


def write_diagnosis(
    found: T, name: str, page: Callable[[T, Texts], str], folder: Path | None, language: Language, unit: LengthUnit
) -> list[str]:
    """Writes `name`.json and `name`.html to a folder, both or none; nothing without one. Raises OUT errors."""
    if folder is None:
        return []
    contents = [
        (f"{name}.json", (found.model_dump_json(indent=1) + "\n").encode()),
        (f"{name}.html", page(found, Texts(language, unit)).encode()),
    ]
    return [str(file) for file in write_all(folder, contents)]
