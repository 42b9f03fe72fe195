"""The sections of the report, and the templates (``*.html.j2``, ``style.css``) that show them."""
