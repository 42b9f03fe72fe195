"""Errors in a line."""

from experiments.bench.store.description import short


def test_an_error_is_a_line_of_200_characters_or_its_kind():
    assert short(ValueError("two\n  lines\tand more")) == "two lines and more"
    assert short(ValueError("long " * 100)) == ("long " * 40)[:200]
    assert short(ValueError("\n")) == short(ValueError()) == "ValueError"
