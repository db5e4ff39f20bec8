"""Parameter sweeps: many runs of a machine, on local cores or a Dask cluster, kept in Zarr."""

from runtime.sweeps.run_sweep import sweep
from runtime.sweeps.study import Study
from runtime.sweeps.study_loading import load_study

__all__ = ["Study", "load_study", "sweep"]
