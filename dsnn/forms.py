"""The form of the networks that runs: in C (``native``) where that is built, else the ``reference`` in NumPy.

The forms agree within 1e-5 in HS and VS, not to the bit (`CONTRIBUTING.md`). So a run notes its form and is never
gone on with by another.
"""

from __future__ import annotations

import os

from dsnn import native

FORMS = ("native", "reference")
VARIABLE = "DSNN_FORM"
"""The environment variable that chooses the form of every model that is not told one."""


class FormError(ValueError):
    """A form that is not known, or not built."""


def chosen(form: str | None = None) -> str:
    """Return the form that runs.

    Parameters
    ----------
    form
        One of `FORMS`; ``None`` for what the environment variable ``DSNN_FORM`` says, and without that for the native
        form where it is built.

    Returns
    -------
    str
        One of `FORMS`.

    Raises
    ------
    FormError
        Of another word, and of ``native`` where it is not built.
    """
    source = "form"
    if form is None:
        form, source = os.environ.get(VARIABLE) or ("reference" if native.missing() else "native"), VARIABLE
    if form not in FORMS:
        raise FormError(f"{source}={form!r}: legal are {' and '.join(FORMS)}")
    if form == "native" and (reason := native.missing()):
        raise FormError(f"{source}={form!r}: the native form {reason}: 'make setup' builds it")
    return form


def note() -> str:
    """Return what a person should know of the form that runs, in one line; empty where it is the native one, or asked
    for.
    """
    reason = native.missing()
    if not reason or os.environ.get(VARIABLE):
        return ""
    return f"the DSNN runs as its reference, some 17 times slower: its native form {reason} ('make setup' builds it)"
