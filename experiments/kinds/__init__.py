"""The kinds of run, a file each, and the functions of Python."""
