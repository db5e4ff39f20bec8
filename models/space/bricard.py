"""Bricard's linkage: six hinges along the edges of a cube, which no count of freedoms lets move.

Five bars of 1 × 0.1 × 0.1 m and 1 kg are joined to each other and to the ground, in the axes y, z,
x, y, z, x:

            o---------.o  (0, 0, 1)
           /|  b5    / |
       b4 / |       /  ground
         /  |      /   |
        o   |     / o--+-------o  y ← z
        | b3|          A  b1  / b2
        |   `                /
        o-------------------o

It is benchmark A04 of the IFToMM technical committee for multibody dynamics: the linkage falls from
rest under gravity along -y. Six times five rows hold thirty coordinates, and one row follows from
the others.

Scenes
------
fall
    The motion from rest.
"""

from codegen import Model


def bricard() -> Model:
    """The linkage."""
    model = Model("bricard", space=True, gravity=(0, -9.81, 0))
    X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    corners = [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)]
    bodies = []
    for k, along in enumerate((0, 1, 2, 0, 1)):
        middle = [(a + b) / 2 for a, b in zip(corners[k], corners[k + 1], strict=True)]
        moments = [0.01 / 6 if axis == along else 1.01 / 12 for axis in range(3)]
        bodies.append(model.body(f"b{k + 1}", 1.0, moments, at=middle))
    chain = (model.ground, *bodies, model.ground)
    for k, (corner, axis) in enumerate(zip(corners, (Y, Z, X, Y, Z, X), strict=True)):
        model.revolute(f"J{k + 1}", chain[k], chain[k + 1], at=corner, axis=axis)
    model.scene("fall", effects=["gravity"])
    return model


model = bricard()
