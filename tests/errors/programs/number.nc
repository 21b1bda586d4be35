(check ge2000t 3:5 NC-NUMBER: "X6,2625" has a comma for its decimal point: read as 6.2625)
G70
G00 X6,2625
M30
