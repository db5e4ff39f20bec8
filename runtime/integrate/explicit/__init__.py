"""Explicit Runge-Kutta methods: what the stages share that are generated from their tableaus."""
