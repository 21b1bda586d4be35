(check ge2000t 3:1 NC-MISPLACED: G02 without coordinates: nothing moves)
G70
G02
M30
