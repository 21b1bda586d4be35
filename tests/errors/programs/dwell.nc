(check fanuc-lathe 3:9 NC-MISPLACED: Z3. beside a dwell: nothing moves)
G21
G04 X2. Z3.
M30
