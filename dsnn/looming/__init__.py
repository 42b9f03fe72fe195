"""Models of looming: the locust's LGMDs and the fly's LPLC2 cells, and what they share."""
