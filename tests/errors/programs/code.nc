(check fanuc-mill 3:1 NC-CODE: "G777" is no code of the dialect fanuc-mill)
G21
G777
M30
