(check fanuc-lathe 3:6 NC-FLOW: block N30 is not in this program)
G21
GOTO 30
M30
