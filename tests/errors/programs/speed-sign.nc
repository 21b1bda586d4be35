(check fanuc-mill 3:1 NC-FEED: S-500: a speed below zero)
G21
S-500 M03
M30
