(check fanuc-mill 4:1 NC-ARC: an arc of radius 0.50000 mm over a chord of 4.00000 mm cannot exist)
G21 F100.
G00 X0. Y0.
G02 X4. Y0. R0.5
M30
