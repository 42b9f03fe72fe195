"""How figures look: style, colours, scoreboards, and how they are saved."""
