"""The unit edge: inside are millimetres and radians; what is printed or read in other units is converted by these."""

from typing import Final

MM_PER_INCH: Final = 25.4
"""Exact by definition (ISO 80000-3)."""

UM_PER_MM: Final = 1000.0

MM_PER_M: Final = 1000.0

URAD_PER_RAD: Final = 1e6

SIGNALS: Final = {"_degC": "°C", "_rpm": "rev/min"}
"""How the columns of signals end, and the unit that says."""

COARSEST_U_UM: Final = 250.0
"""Standard uncertainty above which nothing is measured: of a steel rule, which is read to half a millimetre."""
