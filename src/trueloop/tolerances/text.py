"""Tolerances as a drawing writes them, to absolute limits: `±0.02`, `+0.01/-0.02`, `h6`, `ISO 2768-m`.

Limits of sizes by tolerance class: ISO 286-1:2010, nominal sizes up to 3150 mm.

A class is a letter or two and a grade: `h6` of a shaft (any outer size), `H7` of a hole. The grade gives the width of
the zone, the letter where it lies. Holes are the shafts of their letter turned over, EI = −es and ES = −ei; K, M and N
up to grade 8 and P to ZC up to grade 7 are moved into the material by less: ES = −ei + Δ, Δ = ITn − IT(n − 1), over
3 and up to 500 mm.
"""

import re
from bisect import bisect_left
from dataclasses import dataclass
from typing import Final, TypeAlias

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.tolerances import iso2768
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

MAIN_MM: Final = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150)
"""Upper bounds of the main ranges."""
FINE_MM: Final = (
    *(3, 6, 10, 14, 18, 24, 30, 40, 50, 65, 80, 100, 120, 140, 160, 180, 200, 225, 250, 280, 315, 355, 400, 450, 500),
    *(560, 630, 710, 800, 900, 1000, 1120, 1250, 1400, 1600, 1800, 2000, 2240, 2500, 2800, 3150),
)
"""Upper bounds of the intermediate ranges, of deviations that change faster."""

GRADES: Final = ("01", *map(str, range(19)))
_GRADES_UM: Final = """
0.3 0.5 0.8 1.2 2   3  4  6   10  14  25  40  60  100  140  250  400  600  1000  1400
0.4 0.6 1   1.5 2.5 4  5  8   12  18  30  48  75  120  180  300  480  750  1200  1800
0.4 0.6 1   1.5 2.5 4  6  9   15  22  36  58  90  150  220  360  580  900  1500  2200
0.5 0.8 1.2 2   3   5  8  11  18  27  43  70  110 180  270  430  700  1100 1800  2700
0.6 1   1.5 2.5 4   6  9  13  21  33  52  84  130 210  330  520  840  1300 2100  3300
0.6 1   1.5 2.5 4   7  11 16  25  39  62  100 160 250  390  620  1000 1600 2500  3900
0.8 1.2 2   3   5   8  13 19  30  46  74  120 190 300  460  740  1200 1900 3000  4600
1   1.5 2.5 4   6   10 15 22  35  54  87  140 220 350  540  870  1400 2200 3500  5400
1.2 2   3.5 5   8   12 18 25  40  63  100 160 250 400  630  1000 1600 2500 4000  6300
2   3   4.5 7   10  14 20 29  46  72  115 185 290 460  720  1150 1850 2900 4600  7200
2.5 4   6   8   12  16 23 32  52  81  130 210 320 520  810  1300 2100 3200 5200  8100
3   5   7   9   13  18 25 36  57  89  140 230 360 570  890  1400 2300 3600 5700  8900
4   6   8   10  15  20 27 40  63  97  155 250 400 630  970  1550 2500 4000 6300  9700
-   -   9   11  16  22 32 44  70  110 175 280 440 700  1100 1750 2800 4400 7000  11000
-   -   10  13  18  25 36 50  80  125 200 320 500 800  1250 2000 3200 5000 8000  12500
-   -   11  15  21  28 40 56  90  140 230 360 560 900  1400 2300 3600 5600 9000  14000
-   -   13  18  24  33 47 66  105 165 260 420 660 1050 1650 2600 4200 6600 10500 16500
-   -   15  21  29  39 55 78  125 195 310 500 780 1250 1950 3100 5000 7800 12500 19500
-   -   18  25  35  46 65 92  150 230 370 600 920 1500 2300 3700 6000 9200 15000 23000
-   -   22  30  41  55 78 110 175 280 440 700 1100 1750 2800 4400 7000 11000 17500 28000
-   -   26  36  50  68 96 135 210 330 540 860 1350 2100 3300 5400 8600 13500 21000 33000
"""

_ABOVE_ZERO_MAIN: Final = """
k  0 1  1  1  2  2  2  3  3  4  4  4  5   0  0  0   0   0   0   0   0
m  2 4  6  7  8  9  11 13 15 17 20 21 23  26 30 34  40  48  58  68  76
n  4 8  10 12 15 17 20 23 27 31 34 37 40  44 50 56  66  78  92  110 135
p  6 12 15 18 22 26 32 37 43 50 56 62 68  78 88 100 120 140 170 195 240
"""
"""Lower deviations ei of shafts k (grades 4 to 7), m, n, p."""
_ABOVE_ZERO_FINE: Final = """
r 10 15 19 23 23 28 28 34 34 41 43 51 54 63 65 68 77 80 84 94 98 108 114 126 132 150
  155 175 185 210 220 250 260 300 330 370 400 440 460 550 580
s 14 19 23 28 28 35 35 43 43 53 59 71 79 92 100 108 122 130 140 158 170 190 208 232 252 280
  310 340 380 430 470 520 580 640 720 820 920 1000 1100 1250 1400
t - - - - - - 41 48 54 66 75 91 104 122 134 146 166 180 196 218 240 268 294 330 360 400
  450 500 560 620 680 780 840 960 1050 1200 1350 1500 1650 1900 2100
u 18 23 28 33 33 41 48 60 70 87 102 124 144 170 190 210 236 258 284 315 350 390 435 490 540 600
  660 740 840 940 1050 1150 1300 1450 1600 1850 2000 2300 2500 2900 3200
v - - - - 39 47 55 68 81 102 120 146 172 202 228 252 284 310 340 385 425 475 530 595 660
x 20 28 34 40 45 54 64 80 97 122 146 178 210 248 280 310 350 385 425 475 525 590 660 740 820
y - - - - - 63 75 94 114 144 174 214 254 300 340 380 425 470 520 580 650 730 820 920 1000
z 26 35 42 50 60 73 88 112 136 172 210 258 310 365 415 465 520 575 640 710 790 900 1000 1100 1250
za 32 42 52 64 77 98 118 148 180 226 274 335 400 470 535 600 670 740 820 920 1000 1150 1300 1450 1600
zb 40 50 67 90 108 136 160 200 242 300 360 445 525 620 700 780 880 960 1050 1200 1300 1500 1650 1850 2100
zc 60 80 97 130 150 188 218 274 325 405 480 585 690 800 900 1000 1150 1250 1350 1550 1700 1900 2100 2400 2600
"""
"""Lower deviations ei of shafts r to zc."""
_BELOW_ZERO_MAIN: Final = """
cd 34 46 56 70 85 100
d 20 30 40 50 65 80 100 120 145 170 190 210 230 260 290 320 350 390 430 480 520
e 14 20 25 32 40 50 60 72 85 100 110 125 135 145 160 170 195 220 240 260 290
ef 10 14 18 23 28 35
f 6 10 13 16 20 25 30 36 43 50 56 62 68 76 80 86 98 110 120 130 145
fg 4 6 8 10 12 15
g 2 4 5 6 7 9 10 12 14 15 17 18 20 22 24 26 28 30 32 34 38
h 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0
"""
"""Upper deviations es of shafts cd to h, without their sign."""
_BELOW_ZERO_FINE: Final = """
a 270 270 280 290 290 300 300 310 320 340 360 380 410 460 520 580 660 740 820 920 1050 1200 1350 1500 1650
b 140 140 150 150 150 160 160 170 180 190 200 220 240 260 280 310 340 380 420 480 540 600 680 760 840
c 60 70 80 95 95 110 110 120 130 140 150 170 180 200 210 230 240 260 280 300 330 360 400 440 480
"""
"""Upper deviations es of shafts a, b, c, without their sign."""
_J: Final = """
5 2 2 2 3 4 5 7 9 11 13 16 18 20
6 2 2 2 3 4 5 7 9 11 13 16 18 20
7 4 4 5 6 8 10 12 15 18 21 26 28 32
8 6
"""
"""Lower deviations ei of shafts j by grade, without their sign."""
_J_OF_HOLES: Final = """
6 2 5 5 6 8 10 13 16 18 22 25 29 33
7 4 6 8 10 12 14 18 22 26 30 36 39 43
8 6 10 12 15 20 24 28 34 41 47 55 60 66
"""
"""Upper deviations ES of holes J by grade."""


@dataclass(frozen=True)
class Row:
    """Numbers by range of nominal size, µm: as many as the ranges, from the smallest on; None: not in the standard."""

    bounds_mm: tuple[int, ...]
    numbers: tuple[float | None, ...]

    def at(self, nominal_mm: float) -> float:
        """The number of the range that a size lies in. Raises KeyError where there is none."""
        place = bisect_left(self.bounds_mm, nominal_mm)
        number = self.numbers[place] if place < len(self.numbers) else None
        if number is None:
            raise KeyError(nominal_mm)
        return number


def _rows(text: str, bounds_mm: tuple[int, ...]) -> dict[str, Row]:
    """By the first word of every line; an indented one goes on from the line before."""
    lines = [line.split() for line in text.strip().replace("\n  ", " ").splitlines()]
    return {name: Row(bounds_mm, tuple(map(_parsed_number, words))) for name, *words in lines}


def _parsed_number(word: str) -> float | None:
    return None if word == "-" else float(word)


GRADE_UM: Final = {
    grade: Row(MAIN_MM, tuple(map(_parsed_number, column)))
    for grade, column in zip(GRADES, zip(*map(str.split, _GRADES_UM.strip().splitlines()), strict=True), strict=True)
}
"""Width of the zone by grade."""
BELOW_ZERO_UM: Final = {**_rows(_BELOW_ZERO_MAIN, MAIN_MM), **_rows(_BELOW_ZERO_FINE, FINE_MM)}
"""Distance of the zone below the nominal, of shafts a to h."""
ABOVE_ZERO_UM: Final = {**_rows(_ABOVE_ZERO_MAIN, MAIN_MM), **_rows(_ABOVE_ZERO_FINE, FINE_MM)}
"""Distance of the zone above the nominal, of shafts k to zc."""
J_UM: Final = _rows(_J, MAIN_MM)
J_OF_HOLES_UM: Final = _rows(_J_OF_HOLES, MAIN_MM)


CLASS: Final = re.compile(r"([a-z]{1,2}|[A-Z]{1,2})\s*(\d{1,2})")
LARGEST_MM: Final = MAIN_MM[-1]
DELTA_FROM: Final = 3
"""The standard has Δ from grade 3 on."""
LETTERS: Final = (*BELOW_ZERO_UM, "js", "j", *ABOVE_ZERO_UM)


def deviations_mm(tolerance_class: str, nominal_mm: float) -> tuple[float, float]:
    """Deviations of a class such as `h6` or `JS7`. Raises TOL-FIT (no such class), TOL-SIZE (none at this size)."""
    found = CLASS.fullmatch(tolerance_class.strip())
    if found is None or found[1].lower() not in LETTERS or found[2] not in GRADES:
        raise Code.TOL_FIT.refusal(
            wording("{tolerance_class!r} is not a tolerance class of ISO 286", tolerance_class=tolerance_class),
            hint=wording("letters are a to zc of shafts and A to ZC of holes, grades 01 and 0 to 18: h6, js7, H7"),
            values={"tolerance": tolerance_class},
        )
    letter, grade = found[1], found[2]
    if not 0.0 < nominal_mm <= LARGEST_MM:
        raise _not_there(tolerance_class, nominal_mm, "its tables hold sizes over 0 up to 3150 mm")
    try:
        if nominal_mm <= 1.0 and int(grade) >= 14:
            raise KeyError(grade)
        width = GRADE_UM[grade].at(nominal_mm)
        lower, upper = (_hole if letter.isupper() else _shaft)(letter.lower(), grade, nominal_mm, width)
    except KeyError:
        raise _not_there(tolerance_class, nominal_mm, "the standard leaves this class out at this size") from None
    return lower / UM_PER_MM, upper / UM_PER_MM


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
    return Code.TOL_SIZE.refusal(
        wording(
            "ISO 286 has no {tolerance_class} at {nominal_mm:.4f} mm: {why}",
            tolerance_class=tolerance_class,
            nominal_mm=nominal_mm,
            why=why,
        ),
        hint="give the limits, or `characteristic.nominal` as the drawing has it",
        values={"tolerance": tolerance_class, "nominal_mm": nominal_mm},
    )


Limits: TypeAlias = tuple[float, float]
"""Lower and upper, absolute."""


NUMBER: Final = r"(\d+(?:[.,]\d+)?|[.,]\d+)"
BOTH: Final = re.compile(rf"(?:±|\+/-|\+-)\s*{NUMBER}")
ONE: Final = rf"([+-]\s*{NUMBER}|0(?:[.,]0+)?)"
TWO: Final = re.compile(rf"{ONE}\s*(?:/|;|\s)\s*{ONE}")
SIZED: Final = re.compile(rf"(?:[Øø⌀Φφ]?\s*{NUMBER}\s*)?([A-Za-z]{{1,2}}\s*\d{{1,3}})")
"""A tolerance class, with the size before it or without."""
WIDTH: Final = re.compile(NUMBER)
SIZES: Final = (Quantity.DIAMETER, Quantity.LENGTH, Quantity.RADIUS)
SAME_MM: Final = 1e-6
HINT: Final = wording(
    'write "±0.02", "+0.01/-0.02", a class such as "h6", "ISO 2768-m", or "0.01" of a form; or give the limits'
)


def limits_of(text: str, nominal: float, quantity: Quantity, edge_of: iso2768.Edge, mm_per_unit: float = 1.0) -> Limits:
    """Limits of a characteristic with this nominal, in mm or degrees; numbers of the text in the drawing's unit.

    `mm_per_unit` is 1 or 25.4; angles are in degrees either way. Raises TOL errors.
    """
    given = text.strip().replace("−", "-").replace("–", "-")
    lower, upper = _deviations(given, nominal, quantity, edge_of, 1.0 if quantity is Quantity.ANGLE else mm_per_unit)
    return nominal + lower, nominal + upper


def _deviations(text: str, nominal: float, quantity: Quantity, edge_of: iso2768.Edge, scale: float) -> Limits:
    if quantity is Quantity.FORM:
        return 0.0, _form(text) * scale
    if both := BOTH.fullmatch(text):
        deviation = _number(both[1]) * scale
        return -deviation, deviation
    if two := TWO.fullmatch(text):
        first, second = (_number(two[k]) * scale for k in (1, 3))
        return min(first, second), max(first, second)
    if (general := iso2768.deviation(text, quantity, nominal, edge_of)) is not None:
        return -general, general
    if (sized := SIZED.fullmatch(text)) is None or quantity not in SIZES:
        raise unread(text)
    if sized[1] is not None and abs(_number(sized[1]) * scale - nominal) > SAME_MM:
        raise Code.TOL_SIZE.refusal(
            wording(
                "the tolerance {tolerance!r} is of {size:.4f} mm, the nominal is {nominal:.4f} mm",
                tolerance=text,
                size=_number(sized[1]) * scale,
                nominal=nominal,
            ),
            hint="give `characteristic.nominal` as the drawing has it; left out, it is the profile's",
            values={"tolerance": text, "nominal_mm": nominal},
        )
    return deviations_mm(sized[2], nominal)


def _form(text: str) -> float:
    """A form has a tolerance without sign, "0.01": the width of its zone."""
    if (width := WIDTH.fullmatch(text)) is None:
        raise unread(text)
    return _number(width[1])


def unread(text: str) -> TrueloopError:
    """TOL-TEXT."""
    return Code.TOL_TEXT.refusal(
        wording("the tolerance {tolerance!r} cannot be read", tolerance=text), hint=HINT, values={"tolerance": text}
    )


def _number(text: str) -> float:
    return float(text.replace(" ", "").replace(",", "."))
