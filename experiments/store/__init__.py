"""The folder of a run: what was asked, tables, provenance; and the workers that fill it."""
