"""The three loops around one cut, for docs/three-loops.md."""

from scripts.manual.drawings.svg import arrow, curve, drawing, text, texts


def box(x: float, y: float, lines: list[str], width: float = 150, height: float = 62) -> str:
    """A step, with its words in the middle."""
    shape = f'<rect class="box" x="{x}" y="{y}" width="{width}" height="{height}" rx="6"/>'
    top = y + height / 2 + 5 - 9.5 * (len(lines) - 1)
    return shape + texts((x + width / 2, top), lines, "", "middle")


def three_loops() -> str:
    """From left to right what happens to a part; below it what each loop takes back."""
    y = 90
    steps = [
        box(20, y, ["semi-finish", "cut"]),
        box(215, y, ["probe on the", "machine, gauge"]),
        box(410, y, ["finish cut,", "corrected"]),
        box(605, y, ["measuring", "machine"]),
    ]
    along = [arrow((x, y + 31), (x + 43, y + 31)) for x in (171, 366, 561)]
    real = [
        curve("M95,88 C95,38 485,38 485,88", "good"),
        arrow((95, 76), (95, 88), "good"),
        arrow((485, 76), (485, 88), "good"),
        text((290, 26), "1  real time: the machine's errors, at the temperatures of the moment", "ok", "middle"),
    ]
    process = [
        curve("M290,154 C290,214 485,214 485,160", "plus"),
        arrow((485, 172), (485, 154), "plus"),
        text((388, 226), "2  process-intermittent: out of this part's finish cut", "on", "middle"),
    ]
    post = [
        curve("M680,154 C680,290 95,290 95,160", "minus"),
        arrow((95, 172), (95, 154), "minus"),
        text((388, 282), "3  post-process: offsets, memory, machine model for the parts that follow", "off", "middle"),
    ]
    return drawing(780, 300, "Three loops around one part", [*steps, *along, *real, *process, *post])
