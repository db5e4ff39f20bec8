"""A net of knots and strings, hung up by two of its corners, which swings like a curtain.

      ///                 ///
       o                   o
       | `o---._     _.---o'|
       o   \\    `o-o'    /  o
        \\`o---._ | | _.---o'/
         o  \\    o-o    /  o
          `o---. | | .---o'
                `o-o'

Knots of 0.1 kg, strings of 1 m that do not stretch: distance joints along both directions of a
square lattice. The knots of the first row lie on an arc between the corners, those of the other
rows below them, and all columns lean the same way. The strings along the rows fall into the shape
of a hanging chain, and the columns swing.

With n knots along a side there are n² - 2 free ones and 2 n (n - 1) strings, and 2 n - 4 degrees
of freedom are left: every mesh is a parallelogram and stays one, so that a knot lies at the sum of
a place on the first row and of one on the first column, p_ij = r_i + c_j. A reference needs no
more unknowns than the 2 n - 2 angles of these two polygons.

`net(n)` declares the net with n knots along a side; the file's own has four.

Scenes
------
fall
    The motion from rest.
"""

from math import cos, pi, sin

from codegen import Model

KNOT = 0.1  # kg
ARC = pi / 4
"""Slope of the first row at its corners: the one end falls, the other rises by it, rad."""
LEAN = pi / 9
"""Angle of the columns from the vertical, rad."""


def row_angles(side: int) -> list[float]:
    """Direction of each string of the first row at the start, rad."""
    middle = (side - 2) / 2
    return [ARC * (k - middle) / max(middle, 1) for k in range(side - 1)]


def column_angles(side: int) -> list[float]:
    """Direction of each string of the first column at the start, rad."""
    return [LEAN - pi / 2] * (side - 1)


def knots(angles: list[float]) -> list[tuple[float, float]]:
    """The corners of a polygon from the origin, with sides of 1 m in these directions, m."""
    places = [(0.0, 0.0)]
    for angle in angles:
        x, y = places[-1]
        places.append((x + cos(angle), y + sin(angle)))
    return places


def net(side: int) -> Model:
    """The net with `side` knots along each side."""
    model = Model(f"net_{side}", gravity=(0, -9.81))
    row, column = knots(row_angles(side)), knots(column_angles(side))
    nodes, guess = {}, {}
    for i, (x, y) in enumerate(row):
        for j, (dx, dy) in enumerate(column):
            if j == 0 and i in {0, side - 1}:
                nodes[i, j] = model.ground.at(x, y)
                continue
            knot = nodes[i, j] = model.particle(f"knot_{i}_{j}", mass=KNOT)
            guess |= {knot.x: x + dx, knot.y: y + dy}
    for (i, j), node in nodes.items():
        if i:
            model.distance(f"across_{i}_{j}", nodes[i - 1, j], node, 1.0)
        if j:
            model.distance(f"down_{i}_{j}", nodes[i, j - 1], node, 1.0)
    model.scene("fall", ["gravity"], guess=guess)
    return model


model = net(4)
