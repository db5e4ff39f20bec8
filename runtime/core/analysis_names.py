"""Names of the analyses: those of the methods of a machine, however a user spells them."""

ANALYSES = ("simulate", "kinematics", "inverse_dynamics", "equilibrium")


def analysis_name(text: str) -> str:
    """The name in its usual spelling: ``inverse-dynamics`` and ``inverse`` are one analysis."""
    name = text.strip().replace("-", "_").replace(" ", "_")
    return "inverse_dynamics" if name == "inverse" else name


def analysis_title(name: str) -> str:
    """The name in a sentence: inverse dynamics."""
    return name.replace("_", " ")
