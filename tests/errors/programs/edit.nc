(displace fanuc-lathe 3:5 NC-EDIT: U1. is an increment: moving it by 0.1 mm would move all that follows)
G21
G01 U1. F1.
M30
