"""Colours of pictures and animations, light and dark, told apart by the colour-blind as well.

The lines of bodies and curves are those of M. Okabe and K. Ito, Color Universal Design (2008), in
lightness adapted to either ground: every line stands out from its ground with a contrast of at
least 3 (WCAG 2.2, 1.4.11), texts with 4.5 (1.4.3).
"""

from typing import Literal, NamedTuple

Theme = Literal["light", "dark"]


class Palette(NamedTuple):
    """Colours as ``#rrggbb``, named by what they are for.

    Attributes
    ----------
    background, panel
        Behind the machine; behind tables and controls.
    ink, muted, grid
        Texts and outlines, secondary texts, lines of a grid.
    ground, hatching
        Fill and hatching of the ground.
    joint
        Pins, guides and slots; their inside is the background.
    spring, damper, actuator
        Elements between two bodies.
    driver
        Signs of drivers.
    force, reaction, torque, gravity
        Arrows: applied forces, reactions of joints, torques, gravity.
    contact
        Contacts that are closed, and impacts.
    trace
        Paths of points.
    cursor
        The instant that is shown, in curves and on the time line.
    accent
        What is chosen or has the focus.
    good, bad
        The outcome of a run: as asked for, or ended before its end.
    lines
        Outlines of bodies and curves, in their order.
    fills
        Insides of bodies, in the order of `lines`.
    """

    background: str
    panel: str
    ink: str
    muted: str
    grid: str
    ground: str
    hatching: str
    joint: str
    spring: str
    damper: str
    actuator: str
    driver: str
    force: str
    reaction: str
    torque: str
    gravity: str
    contact: str
    trace: str
    cursor: str
    accent: str
    good: str
    bad: str
    lines: tuple[str, ...]
    fills: tuple[str, ...]

    def line(self, number: int) -> str:
        """The line of a body or curve; they repeat."""
        return self.lines[number % len(self.lines)]

    def fill(self, number: int) -> str:
        """The inside of a body; they repeat."""
        return self.fills[number % len(self.fills)]


LIGHT = Palette(
    background="#ffffff",
    panel="#f5f7f9",
    ink="#1b1f24",
    muted="#57606a",
    grid="#d8dee4",
    ground="#e6e9ec",
    hatching="#6e7781",
    joint="#24292f",
    spring="#00795a",
    damper="#57606a",
    actuator="#9a4f00",
    driver="#9a4f00",
    force="#c2410c",
    reaction="#0063a0",
    torque="#8a3f73",
    gravity="#57606a",
    contact="#c9184a",
    trace="#8a3f73",
    cursor="#c9184a",
    accent="#0063a0",
    good="#1a7f37",
    bad="#c92a2a",
    lines=("#0072b2", "#6c2300", "#006232", "#a96084", "#6e7c21", "#00a0c3", "#4a4a4a"),
    fills=("#cfe6f5", "#f9dcc8", "#cdeade", "#f6dfec", "#eef0cf", "#d5f4fb", "#e2e2e2"),
)
DARK = Palette(
    background="#14181d",
    panel="#1d232a",
    ink="#e6edf3",
    muted="#9aa5b1",
    grid="#333c46",
    ground="#2a323b",
    hatching="#8b96a1",
    joint="#e6edf3",
    spring="#3fc79a",
    damper="#aab4be",
    actuator="#f0a860",
    driver="#f0a860",
    force="#ff8a5c",
    reaction="#6cb8f0",
    torque="#e29cc4",
    gravity="#9aa5b1",
    contact="#ff6b8b",
    trace="#e29cc4",
    cursor="#ff6b8b",
    accent="#6cb8f0",
    good="#4ac26b",
    bad="#ff7b72",
    lines=("#56b4e9", "#f08a3c", "#1fc296", "#e29cc4", "#e3d04a", "#2f86c9", "#c8c8c8"),
    fills=("#1c3b50", "#4d3018", "#14402f", "#4a2f40", "#453f16", "#173550", "#3a3a3a"),
)
PALETTES: dict[Theme, Palette] = {"light": LIGHT, "dark": DARK}
