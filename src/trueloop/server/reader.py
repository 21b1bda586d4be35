"""How a reader wants to be told what is said in sentences and pictures: `Say`, his language and his unit of lengths.

Numbers of an answer are in mm and µm whatever he wants; their names say so.
"""

from typing import Annotated

from fastapi import Depends

from trueloop.domain.page_options import Language, LengthUnit
from trueloop.report.texts.texts import Texts


def _texts(language: Language = "en", unit: LengthUnit = "mm") -> Texts:
    return Texts(language, unit)


Say = Annotated[Texts, Depends(_texts)]
