"""One drawing for each sign convention of docs/signs.md."""

from math import cos, radians, sin

from scripts.manual.drawings.svg import Point, area, arrow, circle, curve, drawing, line, text, texts


def frame() -> str:
    """Axes, order of features and normals of a turned part."""
    axis = 190
    upper: list[Point] = [(90, 70), (250, 70), (250, 110), (400, 110), (480, 150), (480, axis)]
    lower = [(x, 2 * axis - y) for x, y in reversed(upper)]
    shapes = [
        area([(60, 40), (90, 40), (90, 340), (60, 340)], "box"),
        text((75, 30), "chuck", "small", "middle"),
        area(upper + lower),
        line(upper),
        line([(40, axis), (640, axis)], "axis"),
        arrow((480, axis), (610, axis), "line"),
        text((616, axis - 10), "+Z", "strong"),
        arrow((480, axis), (480, 50), "line"),
        texts((490, 56), ["+X, a radius"], "strong"),
        circle((480, axis), 4, "on"),
        texts((492, axis + 22), ["origin: as the", "drawing says"], "small"),
    ]
    for number, at, normal in (
        (1, (170, 70), (0, -1)),
        (2, (250, 90), (1, 0)),
        (3, (325, 110), (0, -1)),
        (4, (440, 130), (0.45, -0.89)),
    ):
        end = (at[0] + 34 * normal[0], at[1] + 34 * normal[1])
        shapes += [arrow(at, end, "good"), text((at[0] - 16, at[1] + 26), str(number), "strong", "middle")]
    shapes += [
        text((186, 44), "n: out of the material", "ok"),
        texts((140, 346), ["1, 2, 3 …: features, from the", "chuck end to the free end"], "small"),
    ]
    return drawing(680, 380, "The frame of a turned part", shapes)


def error() -> str:
    """Part error along the outward normal."""
    shapes = [
        area([(60, 150), (560, 150), (560, 240), (60, 240)]),
        line([(60, 150), (560, 150)]),
        curve("M60,112 C140,100 220,112 300,150 S480,200 560,186", "dash"),
        arrow((130, 150), (130, 108), "plus"),
        text((66, 96), "e > 0: material left on", "on"),
        arrow((470, 150), (470, 190), "minus"),
        text((458, 210), "e < 0: too much taken", "off", "end"),
        arrow((300, 150), (300, 60), "good"),
        text((310, 72), "n, out of the material", "ok"),
        text((66, 172), "nominal", "small"),
        text((556, 178), "measured", "small", "end"),
        text((310, 34), "e = n · (measured − nominal)", "strong", "middle"),
    ]
    return drawing(620, 250, "Part error", shapes)


def correction() -> str:
    """The commanded contour moves against the error."""
    shapes = [
        area([(60, 150), (560, 150), (560, 250), (60, 250)]),
        line([(60, 150), (560, 150)]),
        curve("M60,120 L560,104", "dash"),
        text((556, 94), "measured after the semi-finish cut", "small", "end"),
        text((66, 142), "nominal: the finish program as it is", "small"),
        curve("M60,180 L560,196", "good"),
        text((556, 220), "corrected finish program", "ok", "end"),
        arrow((300, 150), (300, 113), "plus"),
        text((310, 134), "e", "on"),
        arrow((300, 150), (300, 187), "minus"),
        text((310, 174), "−w · e", "off"),
        text((310, 40), "The contour is moved by −w · e along n", "strong", "middle"),
    ]
    return drawing(620, 260, "Correction", shapes)


def diameter() -> str:
    """One error in three counts."""
    axis = 150
    shapes = [
        area([(60, 90), (420, 90), (420, 210), (60, 210)]),
        line([(60, 90), (420, 90)]),
        line([(60, 210), (420, 210)]),
        line([(60, 74), (420, 74)], "dash"),
        line([(60, 226), (420, 226)], "dash"),
        line([(40, axis), (460, axis)], "axis"),
        arrow((360, 90), (360, 74), "plus"),
        arrow((360, 210), (360, 226), "plus"),
        arrow((120, axis), (120, 90), "thin"),
        text((128, 124), "x: a radius", "small"),
        arrow((240, 90), (240, 210), "thin"),
        arrow((240, 210), (240, 90), "thin"),
        text((248, 190), "a diameter", "small"),
        text((440, 66), "measured: 24 µm too thick", "small"),
        texts((440, 100), ["part error  e = +12 µm"], "on"),
        texts((440, 124), ["size, diameter: +24 µm"], "on"),
        texts((440, 170), ["wear X −0.024 mm (diameter)", "wear X −0.012 mm (radius)"], "off"),
        text((440, 222), "by the way the control counts", "small"),
    ]
    return drawing(680, 260, "Diameter and radius", shapes)


def angle() -> str:
    """Contact angle of a nose on face, arc and cylinder."""
    shapes = [
        curve("M60,90 L300,90 A60,60 0 0 1 360,150 L360,250 L60,250 Z", "metal"),
        curve("M60,90 L300,90 A60,60 0 0 1 360,150 L360,250"),
        line([(40, 250), (640, 250)], "axis"),
        text((628, 242), "+z", "small", "end"),
    ]
    for phi, at, name in (
        (0, (360, 200), "φ = 0°: end face"),
        (45, (342.4, 107.6), "φ = 45°: arc"),
        (90, (170, 90), "φ = 90°: cylinder"),
    ):
        away = (cos(radians(phi)), -sin(radians(phi)))
        centre = (at[0] + 26 * away[0], at[1] + 26 * away[1])
        end = (at[0] + 84 * away[0], at[1] + 84 * away[1])
        shapes += [circle(centre, 26, "thin"), arrow(at, end, "good"), circle(at, 4, "on")]
        place = (end[0] + 10, end[1] + 5) if phi < 90 else (end[0] + 40, end[1] + 12)
        shapes.append(text(place, name, "ok"))
    shapes.append(
        texts(
            (60, 290),
            [
                "n: outward normal of the surface; the nose touches where its own normal is the same.",
                "A worn nose errs by φ, on whatever part it cuts.",
            ],
            "small",
        )
    )
    return drawing(680, 320, "Contact angle", shapes)


def machine() -> str:
    """Machine error and its correction."""
    command, actual = (210, 130), (340, 80)
    shapes = [
        circle(command, 6, "off"),
        circle(actual, 6, "on"),
        arrow(command, (actual[0] - 7, actual[1] + 3), "plus"),
        text((262, 84), "E = actual − commanded", "on", "end"),
        text((352, 76), "actual: where the tool is", "small"),
        texts((222, 146), ["commanded: where the control", "believes the tool to be"], "small"),
        arrow(command, (2 * command[0] - actual[0], 2 * command[1] - actual[1]), "minus"),
        text((20, 140), "COMP_MTG = −E", "off"),
        texts((40, 222), ["Commands get COMP_MTG added: the tool then stands where it should."]),
        texts(
            (40, 248), ["A probe's position gets it subtracted: COORDS_ACTUAL = COORDS_CONTROLLER − COMP_MTG"], "small"
        ),
    ]
    return drawing(700, 262, "Machine error", shapes)
