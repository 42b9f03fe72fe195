"""The judges of the claims about clips, by subject."""
