"""Explicit Runge-Kutta methods: what their generated stages share.

The methods are data, one file each in `codegen.tableaus`; ``python -m codegen methods`` writes
their stages, error estimates and dense outputs, `generated.methods`, from them.
"""
