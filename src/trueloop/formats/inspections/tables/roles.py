"""What a column of a table can mean."""

from enum import StrEnum
from typing import Final


class Role(StrEnum):
    """What a column holds. Limits are absolute, tolerances are counted from the nominal value."""

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
        """Whether its cells are numbers."""
        return self in NUMBERS


POINT: Final = (Role.X, Role.Y, Role.Z)
NOMINAL_POINT: Final = (Role.NOMINAL_X, Role.NOMINAL_Y, Role.NOMINAL_Z)
NORMAL: Final = (Role.I, Role.J, Role.K)
LIMITS: Final = (Role.UPPER_LIMIT, Role.LOWER_LIMIT, Role.UPPER_TOLERANCE, Role.LOWER_TOLERANCE)
LENGTHS: Final = frozenset((Role.NOMINAL, Role.ACTUAL, Role.DEVIATION, *LIMITS, *POINT, *NOMINAL_POINT))
"""What is in a unit of length, or of angle."""
NUMBERS: Final = LENGTHS | {*NORMAL, Role.TEMPERATURE, Role.OUTSIDE}
