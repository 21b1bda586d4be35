"""Writes docs/linuxcnc-programs.md: python -m scripts.linuxcnc_programs, in the project's folder."""

from pathlib import Path

from tests.support.linuxcnc_programs import outcomes, table

PAGE = Path("docs/linuxcnc-programs.md")
TEXT = """# LinuxCNC's sample programs

The programs that Debian's `linuxcnc-uspace` installs in its `ncfiles`, run by LinuxCNC's own interpreter and by
trueloop: the same kind of move, ends, centre and sweep for every move, from the same start (G17 G21 G40 G90 G94) and
with the same tools. A motion program is one of which LinuxCNC itself makes cuts here. Written by
`python -m scripts.linuxcnc_programs`; a test holds the table to what is true today.

After a tool change the interpreter asks where the tool stands. LinuxCNC's module `gcode`, which answers for the machine
here, does not note where an arc ended; and trueloop goes by the programmed place where G40 has left the tool beside it.
Programs in which that matters are compared with a straight move of no length written before each tool change, and the
table says so.

Where a finishing cycle (G70) begins under G42, this interpreter takes the tool to be at the end of the contour that it
has just read: its first rapid move ends elsewhere. Later ones do not; no other move of the cycle differs.

{table}
"""

if __name__ == "__main__":
    PAGE.write_text(TEXT.format(table=table(outcomes())), encoding="utf-8")
