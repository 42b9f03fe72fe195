"""Models of looming: the locust's LGMDs, the fly's LPLC2 cells, and their common layers."""
