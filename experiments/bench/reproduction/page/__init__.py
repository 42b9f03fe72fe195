"""What the report shows, section by section, and the templates (``*.html.j2``, ``style.css``) that show it."""
