"""Workers for jobs outside of this process: worker processes on this machine, a Dask cluster."""
