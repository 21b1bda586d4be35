(check fanuc-0 0:0 NC-DIALECT: unknown NC dialect 'fanuc-0')
G21 G00 X1. Z2.
M30
