(offset ge2000t 0:0 NC-OFFSET: 0 statements update the X offset; one is needed)
G70
G00 X1.0
M30
