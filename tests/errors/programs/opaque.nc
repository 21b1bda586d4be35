(check haas-mill 3:1 NC-OPAQUE: G68: the path goes on as if it were not there)
G21
G68 R30.
M30
