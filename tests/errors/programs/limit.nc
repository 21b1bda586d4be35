(check fanuc-lathe 6:1 NC-LIMIT: programs call one another more than 64 deep)
G21
M98 P1
M30
O1
M98 P1
M99
