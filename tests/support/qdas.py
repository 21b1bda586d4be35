"""Q-DAS files as text, of the pieces that a test is about."""


def characteristic(
    number: int,
    name: str = "Diameter 1",
    nominal: str = "10",
    limits: tuple[str, str] = ("9.99", "10.03"),
    unit: str = "mm",
    **more: str,
) -> str:
    """The fields of one characteristic; `more` are others by their keys: `K2120="2"`."""
    known = {"K2002": name, "K2101": nominal, "K2110": limits[0], "K2111": limits[1], "K2142": unit, **more}
    return "".join(f"{key}/{number} {value}\n" for key, value in known.items() if value)


def value_line(*values: str | tuple[str, ...]) -> str:
    """A line of values; of each the value alone, or its parts: value, attribute, time …"""
    return "\x0f".join(one if isinstance(one, str) else "\x14".join(one) for one in values) + "\n"


HEAD = "K0100 2\nK1001/1 4711\nK1002/1 shaft\nK1004/1 b\n"
