"""Limits of sizes by tolerance class: ISO 286-1:2010, nominal sizes up to 3150 mm.

A class is a letter or two and a grade: `h6` of a shaft (any outer size), `H7` of a hole. The grade gives the width of
the zone, the letter where it lies. Holes are the shafts of their letter turned over, EI = −es and ES = −ei; K, M and N
up to grade 8 and P to ZC up to grade 7 are moved into the material by less: ES = −ei + Δ, Δ = ITn − IT(n − 1), over
3 and up to 500 mm.
"""

import re
from typing import Final

from trueloop.errors import Code, TrueloopError
from trueloop.tolerances.iso286_tables import (
    ABOVE_ZERO_UM,
    BELOW_ZERO_UM,
    GRADE_UM,
    GRADES,
    J_OF_HOLES_UM,
    J_UM,
    MAIN_MM,
)
from trueloop.units import UM_PER_MM

CLASS: Final = re.compile(r"([a-z]{1,2}|[A-Z]{1,2})\s*(\d{1,2})")
LARGEST_MM: Final = MAIN_MM[-1]
DELTA_FROM: Final = 3
"""The standard has Δ from grade 3 on."""
LETTERS: Final = (*BELOW_ZERO_UM, "js", "j", *ABOVE_ZERO_UM)


def deviations_mm(tolerance_class: str, nominal_mm: float) -> tuple[float, float]:
    """Lower and upper deviation from the nominal of a class such as `h6` or `JS7`.

    Raises TOL-FIT for a class that the standard does not have, TOL-SIZE where it has none of it at this size.
    """
    found = CLASS.fullmatch(tolerance_class.strip())
    if found is None or found[1].lower() not in LETTERS or found[2] not in GRADES:
        raise TrueloopError(
            Code.TOL_FIT,
            f"{tolerance_class!r} is no tolerance class of ISO 286",
            hint="letters are a to zc of shafts and A to ZC of holes, grades 01 and 0 to 18: h6, js7, H7",
            values={"tolerance": tolerance_class},
        )
    letter, grade = found[1], found[2]
    if not 0.0 < nominal_mm <= LARGEST_MM:
        raise _not_there(tolerance_class, nominal_mm, "its tables hold sizes over 0 up to 3150 mm")
    try:
        width = _width_um(grade, nominal_mm)
        lower, upper = (_hole if letter.isupper() else _shaft)(letter.lower(), grade, nominal_mm, width)
    except KeyError:
        raise _not_there(tolerance_class, nominal_mm, "the standard leaves this class out at this size") from None
    return lower / UM_PER_MM, upper / UM_PER_MM


def _width_um(grade: str, nominal_mm: float) -> float:
    """ITn. Raises KeyError for what the standard does not have."""
    if nominal_mm <= 1.0 and int(grade) >= 14:
        raise KeyError(grade)
    return GRADE_UM[grade].at(nominal_mm)


def _shaft(letter: str, grade: str, nominal_mm: float, width: float) -> tuple[float, float]:
    """Lower and upper deviation ei, es, µm. Raises KeyError for what the standard does not have."""
    if letter == "js":
        return -width / 2, width / 2
    if letter in BELOW_ZERO_UM:
        if letter in ("a", "b") and nominal_mm <= 1.0:
            raise KeyError(letter)
        upper = -BELOW_ZERO_UM[letter].at(nominal_mm)
        return upper - width, upper
    lower = -J_UM[grade].at(nominal_mm) if letter == "j" else _above_zero_um(letter, grade, nominal_mm)
    return lower, lower + width


def _above_zero_um(letter: str, grade: str, nominal_mm: float) -> float:
    """Lower deviation of shafts k to zc; of k other than grades 4 to 7 it is zero."""
    of_size = ABOVE_ZERO_UM[letter].at(nominal_mm)
    return of_size if letter != "k" or grade in ("4", "5", "6", "7") else 0.0


def _hole(letter: str, grade: str, nominal_mm: float, width: float) -> tuple[float, float]:
    """Lower and upper deviation EI, ES, µm. Raises KeyError for what the standard does not have."""
    if letter == "js" or letter in BELOW_ZERO_UM:
        lower, upper = _shaft(letter, grade, nominal_mm, width)
        return -upper, -lower
    upper = J_OF_HOLES_UM[grade].at(nominal_mm) if letter == "j" else _upper_of_hole_um(letter, grade, nominal_mm)
    return upper - width, upper


def _upper_of_hole_um(letter: str, grade: str, nominal_mm: float) -> float:
    """ES of holes K to ZC."""
    n, small, large = int(grade), nominal_mm <= 3.0, nominal_mm > 500.0
    if n < DELTA_FROM or grade == "01" or (letter == "k" and n > 8 and not small):
        raise KeyError(letter)
    if letter == "n" and n > 8 and not small and not large:
        return 0.0
    if letter == "m" and n == 6 and 250.0 < nominal_mm <= 315.0:
        return -9.0  # the one value that does not follow the rule
    moved = 0.0 if small or large or n > (8 if letter in "kmn" else 7) else _delta_um(n, nominal_mm)
    return -ABOVE_ZERO_UM[letter].at(nominal_mm) + moved


def _delta_um(grade: int, nominal_mm: float) -> float:
    return GRADE_UM[str(grade)].at(nominal_mm) - GRADE_UM[str(grade - 1)].at(nominal_mm)


def _not_there(tolerance_class: str, nominal_mm: float, why: str) -> TrueloopError:
    return TrueloopError(
        Code.TOL_SIZE,
        f"ISO 286 has no {tolerance_class} at {nominal_mm:.4f} mm: {why}",
        hint="give the limits, or `nominal` as the drawing has it",
        values={"tolerance": tolerance_class, "nominal_mm": nominal_mm},
    )
