"""What a claim comes to over all its replicates, in one word; and what a list of claims comes to, in a sentence.

Tiles of the report, ``claims.json``, the terminal's table and the table of the README take the word from the field
``overall`` of a verdict, which `experiments.bench.judging.replicates.Replicates.overall` decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Literal, get_args

Overall = Literal["holds", "fragile", "mixed", "fails", "vacuous", "untestable", "untested"]

MEANINGS: Mapping[Overall, str] = MappingProxyType({
    "holds": "it held in every replicate, or in at least 90 % of 20 or more",
    "fragile": "it held in some replicates, in less than 90 % of 20 or more",
    "mixed": "it held in some of fewer than 20 replicates, which are too few to call it fragile",
    "fails": "it held in no replicate",
    "vacuous": "the model keeps it, but answers no translation either: a network that is always silent would keep it",
    "untestable": "what it says of the DSNN holds; the rest hangs on constants of another model that are not known",
    "untested": "nothing here judges it",
})  # fmt: skip
"""Word -> what it means."""
SIGNS: Mapping[Overall, str] = MappingProxyType({
    "holds": "\N{CHECK MARK}", "fragile": "~", "mixed": "\N{PLUS-MINUS SIGN}", "fails": "\N{MULTIPLICATION X}",
    "vacuous": "\N{EMPTY SET}", "untestable": "?", "untested": "\N{EN DASH}",
})  # fmt: skip
"""Word -> the sign that stands before it: colour alone tells no verdict."""
_SENTENCES: Mapping[Overall, tuple[str, str]] = MappingProxyType({
    "holds": ("holds", "hold"),
    "fragile": ("is fragile", "are fragile"),
    "mixed": ("held in some replicates so far", "held in some replicates so far"),
    "fails": ("fails", "fail"),
    "vacuous": ("is vacuous", "are vacuous"),
    "untestable": ("is untestable", "are untestable"),
    "untested": ("was not judged", "were not judged"),
})  # fmt: skip


def grouped(words: Iterable[tuple[str, str]]) -> dict[Overall, list[str]]:
    """Return word -> the claims that it is said of, in the order of `MEANINGS`, without words said of none.

    Parameters
    ----------
    words
        Pairs of a claim's id and its word.

    Raises
    ------
    ValueError
        A word is none of `Overall`.

    Examples
    --------
    >>> grouped([("C1", "fails"), ("C2", "holds")])
    {'holds': ['C2'], 'fails': ['C1']}
    """
    found: dict[Overall, list[str]] = {word: [] for word in get_args(Overall)}
    for claim, word in words:
        if word not in found:
            raise ValueError(f"claim {claim}: overall={word!r}: legal is {', '.join(found)}")
        found[word].append(claim)
    return {word: ids for word, ids in found.items() if ids}


def totals(words: Iterable[tuple[str, str]]) -> list[str]:
    """Return what claims came to, in a phrase for each word; that of claims that hold comes first and names none.

    Examples
    --------
    >>> totals([("C1", "holds"), ("C2", "fails"), ("C3", "fails")])
    ['1 of 3 claims holds', '2 fail: C2, C3']
    """
    own = list(words)
    groups = grouped(own)
    held = len(groups.pop("holds", ()))
    first = f"{held} of {len(own)} claims {_SENTENCES['holds'][held != 1]}"
    return [first, *(f"{len(ids)} {_SENTENCES[word][len(ids) != 1]}: {', '.join(ids)}" for word, ids in groups.items())]
