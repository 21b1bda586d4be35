(check fanuc-mill 3:9 NC-FEED: F-100.: a feed below zero)
G21
G01 X1. F-100.
M30
