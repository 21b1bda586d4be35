(check ge2000t 3:10 NC-WORD: "??" is no word of the dialect ge2000t)
G70
G00 X1.0 ??
M30
