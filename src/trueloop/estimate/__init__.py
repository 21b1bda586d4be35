"""One Gaussian state of what is known of the errors of cuts: terms, observations, update, prediction.

The error along the outward normal at a place of a cut (positive: material left on) is a sum of *terms* (`term.Term`):
basis functions of the place times coefficients with a normal prior. Whatever was measured is linear in it,
y = H·e(places) + noise (`observed.Observed`). `state.State` holds mean and covariance of all coefficients:

    catalogue = turned_catalogue(reach)             # which terms there are (`catalogue.py`)
    sizes = fitted_sizes(catalogue, observed)       # how large they are: marginal likelihood × priors (`sizes.py`)
    known = after_parts(catalogue, sizes, [[touches_of_part_1, inspection_of_part_1]])
    updated = known.state.given(touches_of_part_2)         # exact; `updated.gross`: P(a touch is a gross error)
    expected = updated.state.predict(places)         # mean and covariance of the error, or of functionals of it
    share = updated.state.predict(places, terms=("setting",))  # what one term has in it

Coefficients of what lasts (edge, part type, machine, instrument) stay in the state, those of one part do not, which in
covariance form is exact marginalisation (`history.py`): the cost of a part does not grow with the history.
A correction is minus the predicted mean of the finish cut's error. A correction that was cut is a known input: it is
added to the finish error before this is handed over (E = F + C). Lengths and errors in mm, angles in rad.
"""
