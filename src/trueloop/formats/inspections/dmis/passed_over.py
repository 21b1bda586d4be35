"""Words of DMIS programs and headings that change no result: their statements are passed over without a remark."""

from typing import Final

# fmt: off
NO_RESULT: Final = frozenset((
    "ACLRAT", "ALGDEF", "ASSIGN", "BADTST", "BOUND", "CALIB", "CALL", "CALLM", "CASE", "CLMPID", "CLMPSN", "CLOSE",
    "CONST", "CROSCL", "CUSTID", "CUTCOM", "DATDEF", "DECL", "DECPL", "DELETE", "DEVICE", "DFTCAS", "DISPLY",
    "DMEHW", "DMESW", "DMESWI", "DMESWV", "DMIS", "DMISMD", "DO", "ELSE", "ENDAT", "ENDCAS", "ENDDO", "ENDGO",
    "ENDIF", "ENDMAC", "ENDMES", "ENDSEL", "ENDSIM", "ENDXTN", "EQUATE", "ERROR", "EVAL", "EXTENS", "EXTFIL",
    "FEATUR", "FEDRAT", "FINPOS", "FIXTID", "FIXTSN", "FLY", "FROM", "GEOALG", "GEOM", "GOHOME", "GOTARG", "GOTO",
    "HOME", "IF", "INCLUD", "ITERAT", "JUMPTO", "KEYCHR", "LITDEF", "LOCATE", "LOTID", "MACRO", "MATDEF", "MEAS",
    "MFGDEV", "MODE", "NOTOL", "OBTAIN", "OPEN", "PAMEAS", "PATH", "PAUSE", "PLANID", "POP", "PRCOMP", "PREVOP",
    "PROCID", "PROMPT", "PSTHRU", "PTBUFF", "PTMEAS", "PUSH", "RAPID", "READ", "REFMNT", "REPORT", "RESUME",
    "RMEAS", "ROTAB", "ROTDEF", "ROTHDF", "ROTSET", "SAVE", "SCAN", "SCNMOD", "SCNPLN", "SCNSET", "SELECT",
    "SENSOR", "SIMREQT", "SNSDEF", "SNSET", "SNSGRP", "SNSLCT", "SNSMNT", "TECOMP", "TEMPR", "TEXT", "THLDEF",
    "TOLSET", "TOOLDF", "UNCERT", "VALUE", "VFORM", "WINDEF", "WRIST", "WRITE", "XTERN", "XTRACT", "ZLABEL",
))
# fmt: on
"""From memory of DMIS 5.2 and programs seen."""
