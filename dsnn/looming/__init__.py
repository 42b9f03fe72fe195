"""Models of looming: the locust's LGMD1 and LGMD2, and what they share."""
