"""Sizes of the signs of a picture, in typical lengths, so that machines of all sizes look alike."""

BAR = 0.021  # layout: half width of a bar, in typical lengths
CHEEK = 0.034  # layout: half width of a bar with a slot
PIN = 0.0115  # layout: radius of a pin
SLOT = 0.016  # layout: half width of a slot
BOB = 0.036  # layout: radius of the disc at a centre of mass
PARTICLE = 0.026  # layout: radius of a body that nothing holds
BLOCK = (0.062, 0.038)  # layout: half length and half width of a block on a guide
SAME = 2e-3  # layout: places nearer than this are one
HATCH = 0.0155  # layout: distance of the strokes of a hatching
SPRING = 0.021  # layout: half width of a spring
ARROW = 0.15  # layout: length of an arrow that is not to scale
HEAD = 0.032  # layout: length of an arrow's head
ROUND_ARROW = 0.062  # layout: radius of a driver's round arrow
