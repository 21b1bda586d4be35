(check haas-mill 3:1 NC-OPAQUE: G154: the path goes on as if it were not there)
G21
G154 P1
M30
