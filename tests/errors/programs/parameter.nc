(check ge2000t 3:7 NC-PARAMETER: parameter P46 has no value)
G70
G00 X(P46+0.0625)
M30
