(check fanuc-mill 3:5 NC-DUPLICATE: "G01" after "G00" in one block, of one group: the last counts)
G21 F100.
G00 G01 X1.
M30
