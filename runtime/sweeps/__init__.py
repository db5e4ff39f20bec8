"""Many runs of a machine: ensembles in threads, and sweeps that Zarr stores keep."""
