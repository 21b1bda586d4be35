"""Where a ball that comes along a line first meets the part."""

from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.simulator.stock import REACH_MM, Stock

SPREAD: Final = 21
ROUNDS: Final = 4


def ball_contact_mm(stock: Stock, points_mm: Array, normal: Array, ball_radius_mm: float) -> Array:
    """Position of the ball's centre on each approach line at first contact, from the point along its normal, (n,).

    The ball meets the part where height(y) + √(r² − y²) is largest over the lines beside the approach line, y from −r
    to r: searched on a spread of lines, then closer around the best, to a tenth of a nanometre on smooth surfaces. An
    approach that runs into a neighbouring feature ends at that feature, or at the reach of the search plus r.
    """
    if ball_radius_mm <= 0.0:
        return stock.height_mm(points_mm, normal)
    beside = np.column_stack([normal[:, 1], -normal[:, 0]])
    middle = np.zeros(len(points_mm))
    half_width = ball_radius_mm
    best = np.full(len(points_mm), -np.inf)
    for _ in range(ROUNDS):
        y = np.clip(middle[:, None] + half_width * np.linspace(-1, 1, SPREAD), -ball_radius_mm, ball_radius_mm)
        lines = (points_mm[:, None, :] + y[..., None] * beside[:, None, :]).reshape(-1, 2)
        height = stock.height_mm(lines, np.repeat(normal, SPREAD, axis=0), REACH_MM).reshape(y.shape)
        meets = height + np.sqrt(np.maximum(ball_radius_mm**2 - y**2, 0.0))
        found = np.argmax(meets, axis=1)
        rows = np.arange(len(y))
        best, middle = np.maximum(best, meets[rows, found]), y[rows, found]
        half_width *= 3.0 / (SPREAD - 1)
    return best
