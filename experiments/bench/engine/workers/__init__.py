"""Where jobs run outside of this process: worker processes on this machine, a Dask cluster."""
