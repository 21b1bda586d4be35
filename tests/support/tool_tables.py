"""Tool tables in the form of each control's, made up, and a correction's offset for tool 3."""

from dataclasses import replace
from typing import Final

from tests.support.records import TURNED
from trueloop.domain.proposal import HeldTool, TableRow, ToolOffset
from trueloop.domain.record import Record

LINUXCNC: Final = (
    "T1 P1 D0.800000 Z+0.100000 I+95.000000 J+155.000000 Q1 ;rough, Schrupp\u00e4n\n"
    "; a line of its own\n"
    "T3 P7 X+12.500000 Z-3.25 D0.8 Q2 ;finish DNMG\n"
    "T2 P2 D6 Z10 ;drill"
)
FANUC: Final = (
    "%\nO0001(T\u00d6\u00d6LS)\nG21\nG10 P1 X0. Z0. R0.4 Q3\nG10 P3 X-0.1 Z.05 R0.8 Q3 ;\n"
    "G10 P10003 X-155500 Z-80250 R0.8 Q3\nM30\n%\n"
)
HAAS: Final = (
    "<OFFSETS>\n<TOOL3>\n<X_GEOMETRY>-12.5</X_GEOMETRY>\n<X_WEAR>-0.02</X_WEAR>\n<Z_WEAR>0.01</Z_WEAR>\n"
    "<DIAMETER_WEAR>-0.03</DIAMETER_WEAR>\n</TOOL3>\n</OFFSETS>\n<MD5>0123</MD5>\n"
)
SIEMENS: Final = (
    "%_N_TO1_TOA\r\n;$PATH=/_N_TOA_DIR\r\nMETRIC\r\nCHANDATA(1)\r\n"
    '$TC_TP2[3]="FINISHER"\r\n$TC_DP1[3,1]=500\r\n$TC_DP2[3,1]=3.000\r\n$TC_DP3[3,1]=155.500\r\n'
    "$TC_DP4[3,1]=80.250\r\n$TC_DP6[3,1]=0.400\r\n$TC_DP12[3,1]=-0.050\r\n$TC_DP13[3,1]=0.000\r\n"
    "$P_UIFR[1]=CTRANS(X,0,Z,120.5):CFINE(X,0,Z,0.02)\r\nM17\r\n"
)
HEIDENHAIN: Final = (
    "BEGIN TOOLTURN.TRN MM Version: 'Update:110.24'\n"
    "T     NAME           ZL        XL        DZL       DXL       RS      TO  TYPE\n"
    "1     ROUGH          +100      +40       +0        +0        +0.8    1   ROUGH\n"
    "3     FINISH         +101.5    +42.25    +0.01     -0.05     +0.4    2   FINISH\n"
    "[END]\n"
)
OFFSET: Final = ToolOffset(3, -0.012, 0.004, True, "diameter", "mm", "1" * 64)
"""A shaft 24 µm too thick: the tool goes 12 µm in on the radius and 4 µm out along z."""


def record_with(offset: ToolOffset | None) -> Record:
    """The record of a correction with this tool offset."""
    return replace(TURNED, tool_offset=offset)


def made_at(kind: str, x: str, z: str) -> ToolOffset:
    """The offset of a correction that was made when the row held these numbers."""
    row = TableRow("tool.tbl", "wear" if kind == "wear" else "geometry", x, z, "mm")
    return replace(OFFSET, held=HeldTool(row=row))
