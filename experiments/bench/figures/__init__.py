"""Style of figures, colours, scoreboards, and saving."""
