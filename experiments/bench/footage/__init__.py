"""Footage and cameras, watched live."""
