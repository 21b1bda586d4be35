"""Error terms from measurements: choice of terms, robust fit, zeros of runs, held-out data."""
