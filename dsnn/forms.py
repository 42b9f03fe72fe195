"""Choose the form of the networks: in C (``native``) where it is built, otherwise the ``reference`` in NumPy.

The forms agree within 1e-5 in HS and VS, but not to the bit (`CONTRIBUTING.md`). So a run records its form, and another
form never resumes it.
"""

from __future__ import annotations

import os

from dsnn import native

FORMS = ("native", "reference")
VARIABLE = "DSNN_FORM"
"""The environment variable with the default form of every model."""


class FormError(ValueError):
    """The form of a model is unknown, or is not built."""


def chosen(form: str | None = None) -> str:
    """Choose the form that runs.

    Parameters
    ----------
    form
        One of `FORMS`. ``None`` means the environment variable ``DSNN_FORM``, or else the native form where it is
        built.

    Returns
    -------
    str
        One of `FORMS`.

    Raises
    ------
    FormError
        The form is unknown, or is ``native`` where that is not built.
    """
    source = "form"
    if form is None:
        form, source = os.environ.get(VARIABLE) or ("reference" if native.missing() else "native"), VARIABLE
    if form not in FORMS:
        raise FormError(f"{source} must be {' or '.join(FORMS)}, got {form!r}")
    if form == "native" and (reason := native.missing()):
        raise FormError(f"{source}={form!r}: the native form {reason}: 'make setup' builds it")
    return form


def note() -> str:
    """Explain in one line why the slow form runs; empty for the native form or an explicit choice."""
    reason = native.missing()
    if not reason or os.environ.get(VARIABLE):
        return ""
    return f"the DSNN runs as its reference, some 17 times slower: its native form {reason} ('make setup' builds it)"
