"""What `experiments` offers to Python: run, load, list and compare runs, watch footage."""
