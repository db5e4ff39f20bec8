"""Models to start from, which `linkwright new` writes with a name in place of NAME."""
