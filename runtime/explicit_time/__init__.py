"""Explicit functions of time: where they bend sharply, where their pieces meet, where they end."""
