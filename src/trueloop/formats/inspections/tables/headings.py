"""Roles and units of a table's columns, and the headings by which they are recognised, English and German.

Of two lines for one role the first is the more certain: of two columns for one thing, the one found there is taken.
"""

import re
import unicodedata
from enum import StrEnum
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.formats.inspections.measured_file import Unit

LENGTH_MM: Final = {
    **dict.fromkeys(("mm", "millimeter", "millimetre", "millimeters", "millimetres"), 1.0),
    **dict.fromkeys(("cm",), 10.0),
    **dict.fromkeys(("m", "meter", "metre", "meters", "metres"), 1000.0),
    **dict.fromkeys(("μm", "um", "micron", "microns", "mikrometer", "micrometer", "mikron"), 0.001),
    **dict.fromkeys(("in", "inch", "inches", "zoll", '"', "in."), 25.4),
    **dict.fromkeys(("mil", "thou"), 0.0254),
}
ANGLE_DEG: Final = {
    **dict.fromkeys(("°", "deg", "degree", "degrees", "grad"), 1.0),
    **dict.fromkeys(("rad",), 57.29577951308232),
}
TEMPERATURES: Final = ("°c", "c", "degc", "grad c", "°f", "f", "degf")
UNIT_NAMES: Final = frozenset((*LENGTH_MM, *ANGLE_DEG, *TEMPERATURES))
BRACKETED: Final = re.compile(r"[\[(<{]\s*([^\])>}]*?)\s*[\])>}]")
TRAILING: Final = re.compile(r"(?:\bin\s+|[\s_/,])(\S+)\s*$", re.IGNORECASE)
STATED: Final = re.compile(
    r"(?:\b(?:units?|einheit(?:en)?|ma(?:ß|ss)einheit)\b\s*[:=;,]?\s*"
    r"|\b(?:all )?dimensions(?: are)? in |\bma(?:ß|ss)e in )"
    r"(mm|millimet(?:er|re)s?|in|inch(?:es)?|zoll|μm|um)\b",
    re.IGNORECASE,
)


def unit_named(text: str) -> str:
    """Returns a cell that is a unit's name and nothing else, in the spelling of the tables above; else empty."""
    name = unicodedata.normalize("NFKC", text).casefold().strip().strip("[](){}<> ")
    return name if name in UNIT_NAMES else ""


def unit_in_heading(heading: str) -> str:
    """Returns the unit that a heading ends with or has in brackets; empty where it names none.

    >>> unit_in_heading("Abw. [µm]"), unit_in_heading("Ist in mm"), unit_in_heading("Ist_inch"), unit_in_heading("Ist")
    ('μm', 'mm', 'inch', '')
    """
    for inside in BRACKETED.findall(heading):
        if unit := unit_named(inside):
            return unit
    last = TRAILING.search(heading)
    name = unit_named(last[1]) if last else ""
    return (
        "" if name in ("c", "f", "in", "m") and not re.search(r"[_/]\S+$|\bin\s+\S+$", heading, re.IGNORECASE) else name
    )


def without_unit(heading: str) -> str:
    """Returns the heading without the unit it ends with."""
    last = TRAILING.search(heading)
    return heading[: last.start()] if last and unit_named(last[1]) else heading


def unit_stated_in(text: str) -> Unit | None:
    """Returns the unit of all lengths in a title line: `Unit: mm`, `Maße in mm`; None: none."""
    found = STATED.search(unicodedata.normalize("NFKC", text))
    if found is None or found[1].casefold() in ("μm", "um"):
        return None
    return "inch" if LENGTH_MM[found[1].casefold()] == 25.4 else "mm"


class Role(StrEnum):
    """The role of a column. Limits are absolute, tolerances are counted from the nominal value."""

    CHARACTERISTIC = "characteristic"
    FEATURE = "feature"
    QUANTITY = "quantity"
    NOMINAL = "nominal"
    ACTUAL = "actual"
    DEVIATION = "deviation"
    UPPER_LIMIT = "upper_limit"
    LOWER_LIMIT = "lower_limit"
    UPPER_TOLERANCE = "upper_tolerance"
    LOWER_TOLERANCE = "lower_tolerance"
    TOLERANCE = "tolerance"  # ±0.02, or +0.02/-0.01
    UNIT = "unit"
    X = "x"
    Y = "y"
    Z = "z"
    NOMINAL_X = "nominal_x"
    NOMINAL_Y = "nominal_y"
    NOMINAL_Z = "nominal_z"
    I = "i"  # noqa: E741  the normal's components are named so
    J = "j"
    K = "k"
    PART = "part"
    SERIAL = "serial"
    DATE = "date"
    TIME = "time"
    OPERATOR = "operator"
    DEVICE = "device"
    TEMPERATURE = "temperature"
    REPEAT = "repeat"
    VERDICT = "verdict"
    OUTSIDE = "outside"  # by how much a value is beyond its limits, 0: not

    @property
    def is_number(self) -> bool:
        """Returns whether its cells are numbers."""
        return self in NUMBERS


POINT: Final = (Role.X, Role.Y, Role.Z)
NOMINAL_POINT: Final = (Role.NOMINAL_X, Role.NOMINAL_Y, Role.NOMINAL_Z)
NORMAL: Final = (Role.I, Role.J, Role.K)
LIMITS: Final = (Role.UPPER_LIMIT, Role.LOWER_LIMIT, Role.UPPER_TOLERANCE, Role.LOWER_TOLERANCE)
LENGTHS: Final = frozenset((Role.NOMINAL, Role.ACTUAL, Role.DEVIATION, *LIMITS, *POINT, *NOMINAL_POINT))
"""Roles of values in a unit of length, or of angle."""
OF_VALUES: Final = frozenset((Role.NOMINAL, Role.ACTUAL, Role.DEVIATION, *LIMITS, Role.TOLERANCE))
"""Roles of the numbers of a size."""
NUMBERS: Final = LENGTHS | {*NORMAL, Role.TEMPERATURE, Role.OUTSIDE}


TABLE: Final = """
characteristic: characteristic, characteristic name, char name, merkmal, merkmalsname, merkmalsbezeichnung,
    merkmalbezeichnung, pruefmerkmal, dimension name, dim name, kenngroesse, characteristic id
characteristic: dimension, dim, name, bezeichnung, description, beschreibung, char, label, measure, masse, mass,
    item
characteristic: characteristic no, char no, merkmal nr, merkmalnr, merkmalsnr, balloon, balloon no, bubble, id,
    pos, position nr
feature: feature, feature name, feature id, featureid, element, elementname, geometrieelement, formelement,
    messelement, geometry, geometrie, hole, bohrung
quantity: quantity, characteristic type, char type, merkmalsart, dimension type, messgroesse, groesse, gd&t, gdt
quantity: type, typ, art, kind, symbol, axis, achse, ax, idsymbol, property, eigenschaft, control
nominal: nominal, nom, nominal value, nominal size, nominal dimension, nennmass, nennwert, nenn, soll, sollwert,
    sollmass, target, target value, theoretical, theo, basic dimension, cad value, drawing value,
    zeichnungsmass, basic
actual: actual, act, actual value, actual size, measured, measured value, measured size, meas, ist, istwert,
    istmass, messwert, gemessen, messergebnis, ist wert, ist mass
actual: measurement, reading, value, wert, result, ergebnis, data, messung, ablesung, observation
deviation: deviation, dev, deviation from nominal, abweichung, abw, soll ist, ist soll, soll ist abweichung
deviation: error, err, difference, diff, differenz, delta, fehler
upper_limit: upper limit, upper specification limit, upper spec limit, usl, obere grenze, obergrenze, ogw,
    oberer grenzwert, osg, obere spezifikationsgrenze, oberes grenzmass, hoechstmass, groesstmass, max limit,
    maximum limit, og, upper lim, high limit, hi limit, obere toleranzgrenze, otg, max size, upper spec,
    grenzmass oben, grenzwert oben, grenze oben, toleranzgrenze oben, spezifikationsgrenze oben
lower_limit: lower limit, lower specification limit, lower spec limit, lsl, untere grenze, untergrenze, ugw,
    unterer grenzwert, usg, untere spezifikationsgrenze, unteres grenzmass, mindestmass, kleinstmass, min limit,
    minimum limit, ug, lower lim, low limit, lo limit, untere toleranzgrenze, utg, min size, lower spec,
    grenzmass unten, grenzwert unten, grenze unten, toleranzgrenze unten, spezifikationsgrenze unten
upper_tolerance: upper tolerance, upper tol, uppertol, plus tol, plus tolerance, tol plus, obere toleranz, oberes
    abmass, ob abmass, toleranz oben, tolerance upper, tol upper, tolerance plus, oberes grenzabmass, o tol,
    oberetoleranz, toltop, toleranz plus, plus toleranz, plus, abmass oben, abmass o, o abmass, grenzabmass oben, o
    abm, abm o, abm oben, ob grenzabmass, o grenzabmass, oberes abm, ob abm, obere tol, ob tol, tol oben, tol ob,
    tol o, toleranz o, toleranz ob
lower_tolerance: lower tolerance, lower tol, lowertol, minus tol, minus tolerance, tol minus, untere toleranz,
    unteres abmass, un abmass, toleranz unten, tolerance lower, tol lower, tolerance minus, unteres grenzabmass,
    unteretoleranz, tolbottom, toleranz minus, minus toleranz, minus, abmass unten, abmass u, u abmass, grenzabmass
    unten, unteres abm, un abm, u abm, abm u, abm unten, un grenzabmass, u grenzabmass, untere tol, un tol, tol
    unten, tol un, tol u, toleranz u, toleranz un
tolerance: tolerance, tol, toleranz, plus minus tol, plus minus, plusminus, tol plus minus, toleranzen
unit: unit, units, uom, einheit, masseinheit, einheiten
x: x, actual x, x actual, meas x, x meas, x ist, ist x, measured x, x measured, act x, x act, pos x, x pos
y: y, actual y, y actual, meas y, y meas, y ist, ist y, measured y, y measured, act y, y act, pos y, y pos
z: z, actual z, z actual, meas z, z meas, z ist, ist z, measured z, z measured, act z, z act, pos z, z pos
nominal_x: nominal x, x nominal, nom x, x nom, x soll, soll x, x theo, theo x, nominalx
nominal_y: nominal y, y nominal, nom y, y nom, y soll, soll y, y theo, theo y, nominaly
nominal_z: nominal z, z nominal, nom z, z nom, z soll, soll z, z theo, theo z, nominalz
i: i, nx, normal x, normal i, vector i, vec i
j: j, ny, normal y, normal j, vector j, vec j
k: k, nz, normal z, normal k, vector k, vec k
part: part name, partname, part number, part no, part type, teilebezeichnung, teilename, teilenummer,
    sachnummer, drawing no, drawing number, drawing, zeichnungsnummer, zeichnung, zeichnungs nr, artikel,
    artikelnummer, artikel nr, teile nr, teilenr, product, produkt
serial: serial, serial number, serial no, serialno, serialnumber, sn, s n, ser number, ser no, seriennummer,
    serien nr, seriennr, part serial, part serial number
serial: part id, piece, piece no, sample, sample no, werkstueck, werkstuecknummer, werkstueck nr, teil nr,
    teilnr, teil, muster, muster nr, part, stueck, stueck nr, unit no, dmc, partnb
date: date, datum, messdatum, measurement date, pruefdatum, inspection date, test date
time: time, timestamp, time stamp, date time, datetime, datum zeit, datum uhrzeit, zeitstempel, uhrzeit, zeit,
    messzeit, measured at, date and time, measurement time
operator: operator, bediener, pruefer, messtechniker, inspector, inspected by, geprueft von, operid, user,
    benutzer
device: device, gauge, gage, instrument, cmm, geraet, messgeraet, pruefmittel, messmittel, pruefmittel nr, gage
    id, gauge id, gauge no, measuring device, dme, messmaschine, equipment
device: machine, maschine
temperature: temperature, temp, temperatur, part temperature, werkstuecktemperatur, temp c, teiletemperatur
repeat: repeat, repetition, wiederholung, trial, run, lauf, durchgang, reading no, messung nr, measurement no,
    run no
verdict: verdict, judge, n i o i o, i o n i o,
    status, pass fail, judgement, judgment, bewertung, io nio, ok nok, urteil,
    in tol, ok,
    entscheid, go nogo
outside: exceed, oot, out of tol, out of tolerance, out tol, outtol, ueberschreitung
"""
"""Role, and the headings as `plain` makes them; further lines of a role are less certain."""
EITHER_END: Final = """
upper: max, maximum, upper, oben, high, hi, ob, oberer, obere, tol max, max tol, toleranz max, max toleranz
lower: min, minimum, lower, unten, low, lo, un, unterer, untere, tol min, min tol, toleranz min, min toleranz
"""
"""Headings of limits or of tolerances: the values decide."""
IGNORED_NAMES: Final = """
bemerkung, bemerkungen, comment, comments, dev x, dev y, dev z, dx, dy, dz, err x, err y, err z, grafik, graph,
index, kommentar, lfd, lfd nr, no, note, notes, notiz, nr, remark, remarks, row, trend, x abw, x dev, y abw, y
dev, z abw, z dev, zeile
"""
"""Headings of columns that are not read."""
SIZES: Final = frozenset(("dimension", "dim", "mass", "masse", "measure", "requirement", "spec", "specification"))
"""Headings of names or of nominal values: numbers that are not all whole are values."""
IN_DOUBT: Final = {
    "ut": {"ot": Role.LOWER_TOLERANCE, "lt": Role.UPPER_TOLERANCE},
    "u tol": {"o tol": Role.LOWER_TOLERANCE, "l tol": Role.UPPER_TOLERANCE},
    "utol": {"otol": Role.LOWER_TOLERANCE, "ltol": Role.UPPER_TOLERANCE},
}
"""German `untere` and English `upper` have one initial: the heading of the other end decides."""
PARTNERS: Final = {
    "ot": Role.UPPER_TOLERANCE,
    "otol": Role.UPPER_TOLERANCE,
    "lt": Role.LOWER_TOLERANCE,
    "l tol": Role.LOWER_TOLERANCE,
    "ltol": Role.LOWER_TOLERANCE,
}
OF_QUANTITY: Final = (
    (Quantity.DIAMETER, re.compile(r"durchmesser|[ø⌀∅φ]|\b(?:d|dia|diam|diameter|durchm|dm)\b")),
    (Quantity.RADIUS, re.compile(r"radius|\br\b")),
    (Quantity.LENGTH, re.compile(r"laenge|abstand|\b(?:l|length|distance)\b")),
    (Quantity.ANGLE, re.compile(r"winkel|\bangle\b")),
)
"""Words of quantities in headings of values: `Ø Ist`, `Nenndurchmesser`, `Measured length`."""
UMLAUTS: Final = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue"})
BRACKETS: Final = re.compile(r"[\[(<{].*?[\])>}]")


def plain(heading: str) -> str:
    """Normalises a heading: lower case, no brackets, no punctuation, umlauts as two letters, signs as words.

    >>> plain("Nennmaß [mm]"), plain("+TOL"), plain("Tol. -"), plain("Meas_X")
    ('nennmass', 'plus tol', 'tol minus', 'meas x')
    """
    text = unicodedata.normalize("NFKC", heading.replace("±", "+/-")).casefold().translate(UMLAUTS)
    text = BRACKETS.sub(" ", text).replace("−", "-")
    text = re.sub(r"\+\s*/?\s*-", " plus minus ", text).replace("+", " plus ")
    text = re.sub(r"(?<![^\s_.])-(?=\s*tol)|(?<=tol)[\s.]*-(?=\s|$)|^-$", " minus ", text)
    return re.sub(r"[\s_.:#*/\-–]+", " ", text).strip()


def of_quantity(name: str) -> tuple[str, Quantity | None]:
    """Returns a plain heading without the quantity that it names beside a value, and that; None: it names none.

    >>> [(rest, str(quantity)) for rest, quantity in map(of_quantity, ("istdurchmesser", "ø soll", "radius", "ist"))]
    [('ist', 'diameter'), ('soll', 'diameter'), ('radius', 'radius'), ('ist', 'None')]
    """
    for quantity, words in () if name in KNOWN or name in ENDS else OF_QUANTITY:
        rest = " ".join(words.sub(" ", name, count=1).split())
        if rest != name and (not rest or rest in ENDS or KNOWN.get(rest, ("", 0))[0] in OF_VALUES):
            return rest or name, quantity
    return name, None


def names_in(text: str) -> list[str]:
    """Returns the names of a list with commas, over several lines.

    >>> names_in('''a, b c,
    ... d''')
    ['a', 'b c', 'd']
    """
    return [" ".join(name.split()) for name in text.replace("\n", " ").split(",") if name.strip()]


GOOD: Final = frozenset(
    names_in("ok, pass, passed, io, i o, in, intol, in tol, gut, good, yes, ja, true, accept, accepted, 1")
)
BAD: Final = frozenset(
    names_in(
        "nok, nio, n i o, fail, failed, out, outol, not ok, n ok, out of tol, schlecht, bad, no, nein, false, ng, 0"
    )
)
"""Plain cells of verdicts."""


TYPES: Final = frozenset(
    names_in("part, part id, partnb, teil, teil nr, teilnr, werkstueck, werkstuecknummer, werkstueck nr")
)
"""Headings of serial numbers that are those of part types beside a serial number."""


def _known() -> dict[str, tuple[Role, int]]:
    found: dict[str, tuple[Role, int]] = {}
    ranks: dict[Role, int] = {}
    for entry in re.split(r"\n(?! )", TABLE.strip()):
        key, _, names = entry.partition(":")
        role = Role(key)
        ranks[role] = ranks.get(role, -1) + 1
        found |= dict.fromkeys(names_in(names), (role, ranks[role]))
    return found


KNOWN: Final = _known()
"""Role and rank by the plain heading."""
ENDS: Final = {
    name: end for end, _, names in (line.partition(":") for line in EITHER_END.split("\n")) for name in names_in(names)
}
IGNORED: Final = frozenset(names_in(IGNORED_NAMES))
STATISTICS: Final = re.compile(
    r"(?:mean|average|averages|avg|mittel|mittelwerte?|mw|durchschnitt|x ?quer|x ?bar|median|"
    r"(?:std|s|st|standard) ?(?:dev|deviation|abw|abweichung)|stdev|stabw|\d? ?(?:sigma|σ)|\d ?s|x\u0304|"
    r"streuung|varian(?:z|ce)|"
    r"c[pm]k?|ppk?|cgk?|ppm|ucl|lcl|oeg|ueg|yield|stichprobenumfang|sample size|(?:number|no) of samples|"
    r"(?:samples|parts) (?:in|out of) tol)(?: (?:values?|wert|cpk|x|r|s|n|n 1))*"
)
"""Plain headings of columns of statistics, and first cells of rows of them."""
ENDS_OF_SERIES: Final = re.compile(
    r"(?:min|max|minimum|maximum|range|spannweite|spw|sum|summe|total|count|anzahl|samples|tol|toleranz(?:en)?|"
    r"tolerances?|end)(?: (?:values?|wert|r|s|n))*"
)
"""Statistics as well, beside others or in a table of one row a part; else they may be names of characteristics."""
LETTERS: Final = frozenset(("s", "r", "n"))
"""Statistics in a table of one row a part; else letters of characteristics."""


def is_statistic(name: str, doubtful: bool) -> bool:
    """Returns whether a plain heading or label is that of statistics; with `doubtful`, also one that may be a name.

    >>> is_statistic("std abw", False), is_statistic("spannweite r", True), is_statistic("mean diameter", True)
    (True, True, False)
    """
    if STATISTICS.fullmatch(name):
        return True
    return doubtful and (name in LETTERS or ENDS_OF_SERIES.fullmatch(name) is not None)
