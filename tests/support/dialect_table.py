"""The tables in docs/dialects.md: what becomes of a program of each feature, and what controls make of the same words.

`python -m tests.support.dialect_table` prints them.
"""

import re
from collections.abc import Mapping
from pathlib import Path

from tests.support.spelled_moves import GIVEN_UNIT
from trueloop.errors import Code
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import read_program

WORKS, KEPT, NOT_YET, NONE = "works", "kept", "not yet", "–"

LATHES = ("fanuc-lathe", "fanuc-lathe-b", "haas-lathe")
MILLS = ("fanuc-mill", "haas-mill")


def _for(*, ge2000t: str = "", linuxcnc: str = "", lathe: str = "", mill: str = "", **own: str) -> Mapping[str, str]:
    """Programs by dialect; `lathe` and `mill` serve all those of their kind that have none of their own."""
    shared = dict.fromkeys(LATHES, lathe) | dict.fromkeys(MILLS, mill)
    named = {name.replace("_", "-"): text for name, text in own.items()}
    texts = dict.fromkeys(DIALECTS, "") | {"ge2000t": ge2000t, "linuxcnc": linuxcnc} | shared | named
    return {name: texts[DIALECTS[name].like or name] for name in texts}


FEATURES: Mapping[str, Mapping[str, str]] = {
    "Lines and arcs, by centre": _for(
        okuma_lathe="G00 X2 Z0\nG02 X4 Z-1 I1 K0",
        heidenhain="0 BEGIN PGM A MM\n1 L X+1 Y+0 F100\n2 CC X+0 Y+0\n3 C X+0 Y+1 DR+",
        siemens="G71 G18 DIAMON G0 X2 Z0\nG2 X4 Z-1 I=AC(4) K0",
        ge2000t="G70 G00 X1.0 Z0\nG03 X1.4 Z-.2 I0 K-.2",
        linuxcnc="G21 G18 G0 X1 Z0\nG3 X0 Z1 I-1 K0",
        lathe="G21 G00 X2. Z0.\nG02 X4. Z-1. I1. K0.",
        mill="G21 G00 X1. Y0.\nG03 X0. Y1. I-1. J0.",
    ),
    "Arcs by radius": _for(
        okuma_lathe="G00 X2 Z0\nG02 X4 Z-1 L1",
        heidenhain="0 BEGIN PGM A MM\n1 L X+1 Y+0 F100\n2 CR X+0 Y+1 R+1 DR+",
        siemens="G71 G0 X1 Y0\nG3 X0 Y1 CR=1",
        linuxcnc="G21 G18 G0 X1 Z0\nG3 X0 Z1 R1",
        lathe="G21 G00 X2. Z0.\nG02 X4. Z-1. R1.",
        mill="G21 G00 X1. Y0.\nG03 X0. Y1. R1.",
    ),
    "Helices, all planes": _for(
        siemens="G71 G19 G0 Y1 Z0\nG3 X5 Y0 Z1 CR=1",
        linuxcnc="G21 G19 G0 Y1 Z0\nG3 X5 Y0 Z1 R1",
        mill="G21 G19 G00 Y1. Z0.\nG03 X5. Y0. Z1. R1.",
    ),
    "More than one turn (P)": _for(
        heidenhain="0 BEGIN PGM A MM\n1 L X+1 Y+0 F100\n2 CP IPA+720 IZ-1 DR+",
        siemens="G71 G17 G0 X1 Y0\nG3 X1 Y0 I-1 J0 TURN=2",
        linuxcnc="G21 G17 G0 X1 Y0\nG3 X1 Y0 I-1 P3",
    ),
    "Increments": _for(
        okuma_lathe="G91 G00 X1",
        heidenhain="0 BEGIN PGM A MM\n1 L IX+1 F100",
        siemens="G71 G91 G0 X1\nY=IC(2) X=AC(4)",
        ge2000t="G70 G91 G00 X1.0",
        linuxcnc="G21 G91 G0 X1",
        lathe="G21 G00 U1. W-1.",
        fanuc_lathe_b="G21 G91 G00 X1. Z-1.",
        mill="G21 G91 G00 X1.",
    ),
    "Packed words": _for(
        okuma_lathe="G90M03S2000",
        siemens="G90G71M3S2000",
        ge2000t="G90G70M03S2000",
        linuxcnc="G90G20M3S2000",
        lathe="G20G97M03S2000",
        mill="G90G20M03S2000",
    ),
    "Optional blocks, comments, tape marks": _for(
        okuma_lathe="%\nO1 (A)\n/G90\n%",
        heidenhain="0 BEGIN PGM A MM\n1 * - A\n/2 L X+1 ; B",
        siemens="%_N_A_MPF\n;$PATH=/_N_MPF_DIR\n/G71 ; mm",
        ge2000t="%\n/G70 ! inch\n%",
        linuxcnc="%\n/G21 (mm) ; mm\n%",
        lathe="%\nO1 (A)\n/G21\n%",
        mill="%\nO1 (A)\n/G21\n%",
    ),
    "Parameters and expressions": _for(
        okuma_lathe="VC1=3\nG00 X=VC1*2",
        heidenhain="0 BEGIN PGM A MM\n1 Q1 = 2 * (3 + 4)\n2 L X+Q1 F100",
        siemens="DEF REAL LENGTH=30\nG71 R1=LENGTH/2\nG0 X=R1+10",
        ge2000t="G70 P4=(1.0+.5)\nG00 X(P4*2.0)",
        linuxcnc="G21 #<a>=[1+2]\nG0 X[#<a>*2]",
        lathe="G21\n#1=1.+2.\nG00 X[#1*2.]",
        mill="G21\n#1=1.+2.\nG00 X-#1",
    ),
    "Functions": _for(
        heidenhain="0 BEGIN PGM A MM\n1 FN 6: Q1 = SIN +30\n2 L X+Q1 F100",
        siemens="G71 G0 X=SQRT(4)*SIN(30)",
        linuxcnc="G21 G0 X[SIN[30]]",
        lathe="G21 G00 X[SIN[30.]]",
        mill="G21 G00 X[SQRT[4.]]",
    ),
    "Conditions, loops, jumps": _for(
        okuma_lathe="V1=0\nIF [V1 EQ 0] N1\nN1 G00 X1",
        heidenhain="1 LBL 1\n2 FN 1: Q1 = +1 + +1\n3 FN 12: IF +Q1 LT +1 GOTO LBL 1\n4 CALL LBL 1 REP 2",
        siemens="R1=0\nWHILE R1<3\nR1=R1+1\nENDWHILE\nIF R1==3 GOTOF A\nA: FOR R2=1 TO 2\nENDFOR",
        linuxcnc="#1=0\no1 while [#1 LT 3]\n#1=[#1+1]\no1 endwhile",
        lathe="#1=0\nWHILE[#1LT3]DO1\n#1=#1+1\nEND1\nIF[#1EQ3]GOTO9\nN9",
        mill="#1=0\nN1 #1=#1+1\nIF[#1LT3]GOTO1",
    ),
    "Subprograms of the same file": _for(
        heidenhain="1 CALL LBL 2\n2 M30\n3 LBL 2\n4 LBL 0",
        siemens="%_N_A_MPF\nPART P2\nM30\n%_N_PART_SPF\nG71\nM17",
        linuxcnc="o1 sub\nG21\no1 endsub\no1 call",
        lathe="O1 M98 P2 L3\nM30\nO2 G21\nM99",
        mill="O1 M98 P2 L3\nM30\nO2 G21\nM99",
    ),
    "Blocks called by number (M97)": _for(
        haas_lathe="M97 P9 L2\nM30\nN9 G21\nM99", haas_mill="M97 P9\nM30\nN9 G21\nM99"
    ),
    "Macro calls with arguments (G65)": _for(
        lathe="G65 P2 Z5.\nM30\nO2 G21\nG00 Z#26\nM99", mill="G65 P2 Z5.\nM30\nO2 G21\nG00 Z#26\nM99"
    ),
    "Macros called after each move (G66)": _for(
        lathe="G21 G66 P2 Z5.\nG00 X1.\nG67\nM30\nO2 G00 Z#26\nM99",
        mill="G21 G66 P2 Z5.\nG00 X1.\nG67\nM30\nO2 G00 Z#26\nM99",
    ),
    "Contours of the finishing cycle (G70)": _for(
        okuma_lathe="G00 X9 Z1\nG87 NLAP1\nNLAP1 G81\nG00 X1\nG01 Z-5\nG80",
        siemens='%_N_A_MPF\nG71 G18 DIAMON G0 X9 Z1\nCYCLE95("P",1,,,,,,.1,5)\nM30\n%_N_P_SPF\nG1 X1 Z0\nZ-5\nX9\nM17',
        linuxcnc="G18 G21 G0 X9\no1 sub\nG0 X1\nG1 Z-5\nX9\no1 endsub\nG70 Q1 D.1 P2",
        lathe="G21\nG70 P1 Q2\nM30\nN1 G00 X1.\nN2 Z1.",
    ),
    "Roughing cycles (G71–G73)": _for(
        okuma_lathe="G00 X9 Z1\nG85 NLAP1 D1 U.1 W.1\nNLAP1 G81\nG00 X1\nG01 Z-5\nX9\nG80",
        siemens='%_N_A_MPF\nG71 G18 DIAMON G0 X9 Z1\nCYCLE95("P",1,,,,.1,,,1)\nM30\n%_N_P_SPF\nG1 X1 Z0\nZ-5\nX9\nM17',
        linuxcnc="G18 G21 G0 X9\no1 sub\nG0 X1\nG1 Z-5\nX9\no1 endsub\nG71 Q1 D.1\nG72.1 Q1",
        lathe="G21 G00 X9. Z1.\nG71 U1. R.1\nG71 P1 Q2 U.1 W.1 F.1\nN1 G00 X1.\nN2 G01 Z-5.",
    ),
    "Grooving cycles (G74, G75)": _for(
        okuma_lathe="G00 X9 Z1\nG73 X1 Z-5 K1 D1 L2 F.1",
        siemens="CYCLE93(20,-5,3,2)",
        lathe="G21 G00 X9. Z1.\nG75 R.1\nG75 X1. Z-5. P1000 Q1000 F.1",
    ),
    "Threads in passes (G76)": _for(
        okuma_lathe="G00 X9 Z1\nG71 X1 Z-5 D1 H1 F1",
        siemens="CYCLE97(1.5,,0,-20,20,20,3,1,0.9,0.1,30,0,6,2,1,1)",
        linuxcnc="G21 G18 G0 X9\nG76 P1 Z-5 I-1 J.5 K1",
        lathe="G21 G00 X9.\nG76 P010000 Q10 R.01\nG76 X1. Z-5. P100 Q100 F1.",
        haas_lathe="G21 G00 X9.\nG76 X1. Z-5. K.1 D.1 F1.",
    ),
    "Simple turning cycles": _for(
        ge2000t="G70\nG00 X6.0 Z.1\nG81 X5.0 Z-4.0 P1=0.2 P2=-3.0 F.01",
        lathe="G21 G90 X10. Z-5. F.1\nX9.\nG94 X8. Z-3.",
        fanuc_lathe_b="G21 G77 X10. Z-5. F.1\nX9.",
    ),
    "Threads in one pass": _for(
        siemens="G71 G33 Z-5 K1", linuxcnc="G21 G33 Z-5 K1", lathe="G21 G32 Z-5. F1.", fanuc_lathe_b="G21 G33 Z-5. F1."
    ),
    "Drilling cycles": _for(
        heidenhain="0 BEGIN PGM A MM\n1 CYCL DEF 200 D ~\nQ200=1 ~\nQ201=-5 ~\nQ203=0\n2 L X+1 F9 M99",
        siemens="G71 MCALL CYCLE81(10,0,2,-5)\nX1 F9",
        linuxcnc="G21 G81 X1 Z-1 R1",
        lathe="G21 G83 Z-5. R-1. F.1",
        haas_lathe="G21 G81 Z-5. R-1. F.1",
        mill="G21 G81 X1. Z-1. R1. F9.",
    ),
    "Splines (G5, G5.1, G5.2)": _for(
        linuxcnc="G17 G21 G5 X9 Y0 I1 J1 P-1 Q1 F9\nG5.1 X18 I1 J9\nG5.2 P1\nX20 Y9 P1\nX30 P2\nG5.3"
    ),
    "Corners between two blocks (,R ,C)": _for(
        heidenhain="0 BEGIN PGM A MM\n1 L X+9 F100\n2 RND R5\n3 L Y+9",
        siemens="G71 G1 X9 F1 RND=0.5\nY9 CHF=0.5\nX0 CHR=0.5\nY0",
        lathe="G21 G01 X9. ,R.5\nZ9. ,C.5\nX0.",
        mill="G21 G01 X9. ,C.5\nY9. ,R.5\nX0.",
    ),
    "Angles in place of a coordinate (A)": _for(siemens="G71 G18 DIAMOF G1 X1 ANG=45 F1", lathe="G21 G01 X1. A45."),
    "Path of the tool under G41, G42": _for(
        okuma_lathe="G42 G01 X9 F1",
        heidenhain="0 BEGIN PGM A MM\n1 L X+1 RL F100",
        siemens="G71 G41 G1 X9 F1",
        ge2000t="G70 G42 G01 X2.0 F1",
        linuxcnc="G21 G42 D1\nG1 X5",
        lathe="G21 G42 G01 X9. F1.",
        mill="G21 G42 D01 G01 X9. F1.",
    ),
    "Work offsets chosen and set": _for(
        heidenhain="0 BEGIN PGM A MM\n1 CYCL DEF 7.0 DATUM\n2 CYCL DEF 7.1 X+1",
        siemens="G505",
        linuxcnc="G21 G10 L2 P2 X1\nG55",
        lathe="G21 G10 L2 P2 X1.\nG55",
        mill="G21 G10 L2 P2 X1.\nG55",
    ),
    "Position register, machine position": _for(
        heidenhain="0 BEGIN PGM A MM\n1 L Z+0 FMAX M91",
        siemens="G71 TRANS X1\nSUPA G0 X0",
        ge2000t="G70 G92 X1.0",
        linuxcnc="G21 G92 X1\nG53 G0 X0",
        lathe="G21 G50 X1. S2000\nG53 G00 X0.",
        fanuc_lathe_b="G21 G92 X1.\nG53 G00 X0.",
        mill="G21 G92 X1.\nG53 G00 X0.",
    ),
    "Reference point (G28)": _for(
        siemens="G74 X1=0",
        linuxcnc="G21 G28",
        lathe="G21 G28 U0. W0.",
        fanuc_lathe_b="G21 G91 G28 X0. Z0.",
        mill="G21 G91 G28 Z0.",
    ),
    "Lengths of tools that are given (G43)": _for(linuxcnc="G43 H1", mill="G43 H01"),
    "Offsets of tools that are given (T0101)": _for(lathe="T0101"),
    "Further work offsets (G54.1 P1)": _for(mill="G54.1 P1", haas_mill="G154 P1", haas_lathe="G154 P1"),
    "Offset data (G10)": _for(linuxcnc="G21 G10 L1 P1 X1", lathe="G21 G10 P1 X.01", mill="G21 G10 L10 P1 R1."),
    "Turned and mirrored coordinates": _for(
        heidenhain="0 BEGIN PGM A MM\n1 CYCL DEF 10.1 ROT+30\n2 CYCL DEF 10.1 ROT+0\n3 CYCL DEF 8.1 X\n4 L X+1 Y+2 F9",
        siemens="G71 G17\nAROT RPL=30\nAMIRROR X0\nG1 X1 Y1 F9",
        linuxcnc="G21 G10 L2 P1 R30\nG0 X1 Y1",
        fanuc_mill="G21 G51.1 X0.\nG68 X0. Y0. R30.\nG00 X1. Y1.\nG69 G50.1 X0.",
        haas_mill="G21 G51 X0. Y0. Z0. P2.\nG68 X0. Y0. R30.\nG00 X1. Y1.\nG69\nG50\nG101 X0.\nG100 X0.",
        lathe="G21 G68",
    ),
    "Polar coordinates in the plane": _for(
        heidenhain="0 BEGIN PGM A MM\n1 CC X+0 Y+0\n2 LP PR+5 PA+30 F9",
        siemens="G71 G111 X0 Y0\nG1 AP=30 RP=5 F9",
        linuxcnc="G21 G0 @5 ^30",
        fanuc_mill="G21 G17 G90 G16\nG00 X5. Y30.\nG15",
    ),
    "High speed, smoothing, tolerance": _for(
        heidenhain="0 BEGIN PGM A MM\n1 CYCL DEF 32.0 TOLERANCE\n2 CYCL DEF 32.1 T0.01\n3 L X+1 F100",
        siemens="G71 SOFT FFWON G642 COMPCAD\nCYCLE832(0.01,_FINISH,1)\nG1 X1 F1",
        linuxcnc="G21 G64 P0.002\nG1 X1 F1",
        lathe="G21 G08 P1\nG05.1 Q1\nG05 P10000\nG01 X1. F1.",
        mill="G21 G08 P1\nG05.1 Q2 X0 Y0 Z0\nG05 P10000\nG61.1 G01 X1. F1.",
        haas_lathe="G21 G187 P3 E0.01\nG01 X1. F1.",
        haas_mill="G21 G187 P3 E0.01\nG103 P1\nG01 X1. F1.",
    ),
    "Further axes, polar interpolation": _for(
        okuma_lathe="G01 C90 F1",
        heidenhain="0 BEGIN PGM A MM\n1 L C+90 F100",
        siemens="G71 G1 C90 F1",
        lathe="G21 G12.1\nG01 C90. F1.",
        mill="G21 G01 A90. F1.",
    ),
}


def outcome(text: str, dialect: str) -> str:
    """What becomes of a program: it works, is kept as it is and said, or is not known.

    A block works when its moves are in the path, whatever is said of how they were taken.
    """
    if not text:
        return NONE
    program = read_program(text.encode(), dialect, unit=GIVEN_UNIT.get(dialect))
    path = program.run(strict=False, tools=[CutterTool(0.4, tip=0, length_mm=1.0, offset_mm=(1.0, 0.0, 1.0))])
    findings = (*program.findings, *path.findings)
    codes, moved = {finding.code for finding in findings}, set(path.line.tolist())
    if codes & {Code.NC_WORD, Code.NC_CODE}:
        return NOT_YET
    if codes - {Code.NC_OPAQUE}:
        raise AssertionError(f"{text!r} in {dialect}: {codes}")
    return WORKS if all(finding.place.line in moved for finding in findings) else KEPT


def table() -> str:
    """The table in Markdown."""
    rows = [("Feature", *DIALECTS), ("---",) * (len(DIALECTS) + 1)]
    rows += [(name, *(outcome(texts[dialect], dialect) for dialect in DIALECTS)) for name, texts in FEATURES.items()]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


CRATE = Path(__file__).parents[2] / "crates/nc-program"
CONTROLS = (CRATE / "controls.tsv", *sorted((CRATE / "controls").glob("*.tsv")))
PARAMETER = re.compile(r'Parameter \{ name: "([^"]+)", says: "([^"]+)" \}')
EVIDENCE = {"manual": "manual", "secondary": "another text", "run": "interpreter run", "memory": "**not confirmed**"}


def controls() -> str:
    """What controls make of the same words, in Markdown: what is not confirmed first."""
    texts = [table.read_text(encoding="utf-8").splitlines()[1:] for table in CONTROLS]
    lines = [line.split("\t") for text in texts for line in text]
    rows = [("Control", "Word or rule", "What it does", "Parameter", "Evidence", "By"), ("---",) * 6]
    for names, item, value, meaning, source, evidence, _ in sorted(lines, key=lambda row: row[5] != "memory"):
        asked = ", ".join(f"`{name}` ({says})" for name, says in PARAMETER.findall(value))
        rows.append((names.replace(" ", ", "), item.replace("_", " "), meaning, asked, EVIDENCE[evidence], source))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


if __name__ == "__main__":
    print(table(), controls(), sep="\n\n")
