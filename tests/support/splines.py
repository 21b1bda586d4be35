"""Generated splines of LinuxCNC: G5, G5.1, G5.2 to G5.3."""

from hypothesis import strategies as st

coordinates = st.integers(-400, 400).map(lambda steps: f"{steps / 16:.4f}")
weights = st.integers(1, 40).map(lambda steps: f"{steps / 8:.3f}")


@st.composite
def cubics(draw: st.DrawFn) -> list[str]:
    """One or more, of which the later ones may go on as the one before ended."""
    blocks = []
    for number in range(draw(st.integers(1, 3))):
        x, y, i, j, p, q = (draw(coordinates) for _ in range(6))
        ahead = f" I{i} J{j}" if number == 0 or draw(st.booleans()) else ""
        blocks.append(f"G5 X{x} Y{y}{ahead} P{p} Q{q}")
    return blocks


@st.composite
def quadratics(draw: st.DrawFn) -> list[str]:
    """One or more."""
    blocks = []
    for _ in range(draw(st.integers(1, 3))):
        x, y, i, j = (draw(coordinates) for _ in range(4))
        blocks.append(f"G5.1 X{x} Y{y} I{i} J{j}")
    return blocks


@st.composite
def points(draw: st.DrawFn) -> list[str]:
    """Control points with their weights, of any order that they suffice for."""
    count = draw(st.integers(2, 8))
    order = draw(st.integers(1, min(count + 1, 5)))
    blocks = [f"X{draw(coordinates)} Y{draw(coordinates)} P{draw(weights)}" for _ in range(count)]
    first = f" X{draw(coordinates)} Y{draw(coordinates)}" if draw(st.booleans()) else ""
    return [f"G5.2 P{draw(weights)} L{order}{first}", *blocks, "G5.3"]


splines = st.lists(st.one_of(cubics(), quadratics(), points()), min_size=1, max_size=3)
