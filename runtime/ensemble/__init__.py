"""Many runs of one machine, as rows of one dataset."""
