"""Elements → the equations of a scene: Φ, Φ_q, ν, γ, M, Q, V and switching functions."""
