"""Texts of pages: in English as in the code, in German as in `german.toml`; numbers in the reader's unit."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, TypeVar

from trueloop.domain.option import Language, LengthUnit, PageOptions
from trueloop.report.shape import Shape
from trueloop.report.style import plain, signed
from trueloop.units import MM_PER_INCH, UM_PER_MM
from trueloop.wording import MINUS, Signed, Um, Wording

UIN_PER_UM: Final = 1000.0 / MM_PER_INCH
"""Microinches."""


@cache
def german() -> Mapping[str, str]:
    """Returns the German texts by their English originals."""
    tables = tomllib.loads((Path(__file__).parent / "german.toml").read_text(encoding="utf-8"))
    return {english: text for table in tables.values() for english, text in table.items()}


class _Number(float):
    """A number that is formatted with a decimal comma."""

    def __format__(self, spec: str) -> str:
        return super().__format__(spec).replace(".", ",")


@dataclass(frozen=True)
class Texts:
    """A page's language and unit. Called with an English text it gives the reader's; `{um}` and `{mm}` in a text are
    the units of errors and of lengths.

    >>> from trueloop.report.texts.texts import Texts
    >>> Texts("de", "inch").error(25.4), Texts("de").mm(1.5)
    ('+1000', '1,500')
    """

    language: Language = "en"
    unit: LengthUnit = "mm"

    @classmethod
    def of(cls, options: PageOptions, program_unit: LengthUnit | None) -> "Texts":
        """Makes texts as the options want them; where they name no unit, that of the program."""
        return cls(options.language, options.unit or program_unit or "mm")

    def __call__(self, text: str, /, **values: object) -> str:
        """The text with its values. Texts among them are taken as they are: escape them before."""
        template = german()[text] if self.language == "de" else text
        said = {name: self.value(value) for name, value in values.items()}
        return template.format_map({"um": self.um, "mm": self.mm_name, **said})

    def note(self, words: str) -> str:
        """Translates a sentence of the calculation; one that is nothing but text is left as it is."""
        return self(words.template, **words.values) if isinstance(words, Wording) else words

    def refusal(self, meaning: str, message: str) -> str:
        """Translates the message of an error; before one that is nothing but text stands the meaning of its code."""
        known = self.language == "en" or isinstance(message, Wording) or meaning not in german()
        return self.note(message) if known else f"{self(meaning)}: {message}"

    def value(self, value: object) -> object:
        """Formats a value of a text for the reader."""
        if isinstance(value, str):
            return self.note(value)
        if isinstance(value, Um):
            return f"{self._length(value)} {self.um}"
        if isinstance(value, Signed):
            return self.spelled(str(value))
        return _Number(value) if isinstance(value, float) and self.language == "de" else value

    def spelled(self, number: str) -> str:
        """Writes a number with the language's decimal sign."""
        return number.replace(".", ",") if self.language == "de" else number

    def _length(self, length: Um) -> str:
        inch = self.unit == "inch"
        spec = length.spec.replace(".1f", ".0f").replace(".2f", ".1f") if inch else length.spec
        number = f"{length.mm * UM_PER_MM * self.per_um:{spec.replace('g', '.3g') if inch else spec}}"
        return self.spelled(number.replace("-", MINUS))

    @property
    def separators(self) -> str:
        """Returns Plotly's separators: the decimal sign, and that between thousands."""
        return ",." if self.language == "de" else ".,"

    @property
    def um(self) -> str:
        """Returns the unit of errors."""
        return "µin" if self.unit == "inch" else "µm"

    @property
    def mm_name(self) -> str:
        """Returns the unit of lengths."""
        return "in" if self.unit == "inch" else "mm"

    @property
    def per_um(self) -> float:
        """Returns a micrometre in the unit of errors."""
        return UIN_PER_UM if self.unit == "inch" else 1.0

    @property
    def per_mm(self) -> float:
        """Returns a millimetre in the unit of lengths."""
        return 1.0 / MM_PER_INCH if self.unit == "inch" else 1.0

    @property
    def slope_name(self) -> str:
        """Returns the unit of slopes."""
        return "µin/in" if self.unit == "inch" else "µm/mm"

    def error(self, um: float, decimals: int = 1) -> str:
        """Formats an error of so many µm, with its sign."""
        return self.spelled(signed(um * self.per_um, self._fewer(decimals)))

    def size(self, um: float, decimals: int = 1) -> str:
        """Formats a length of so many µm."""
        return self.spelled(plain(um * self.per_um, self._fewer(decimals)))

    def slope(self, um_per_mm: float, decimals: int = 2) -> str:
        """Formats a slope of so many µm/mm, with its sign."""
        inch = self.unit == "inch"
        return self.spelled(signed(um_per_mm * (UM_PER_MM if inch else 1.0), 0 if inch else decimals))

    def mm(self, mm: float, decimals: int = 3) -> str:
        """Formats a length of so many mm: in inches with one decimal more."""
        return self.spelled(plain(mm * self.per_mm, decimals + (self.unit == "inch")))

    def number(self, value: float, decimals: int = 1) -> str:
        """Formats a number without a unit."""
        return self.spelled(plain(value, decimals))

    def _fewer(self, decimals: int) -> int:
        return max(decimals - 1, 0) if self.unit == "inch" else decimals


ENGLISH: Final = Texts()


S = TypeVar("S", bound=Shape)


def said(shape: S, say: Texts) -> S:
    """Returns the shape with every sentence translated by `say`; numbers and names stay."""
    return type(shape).model_validate(_said(shape.model_dump(), say))


def _said(value: Any, say: Texts) -> Any:
    if isinstance(value, Wording):
        return say.note(value)
    if isinstance(value, dict):
        return {name: _said(one, say) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_said(one, say) for one in value]
    return value
