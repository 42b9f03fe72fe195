"""The Python interface of `experiments`: run, load, list and compare runs, watch footage."""
