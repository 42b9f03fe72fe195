"""Messages that lead on: the known name that a mistyped one was meant for."""

from scenes.hints import closest

KNOWN = ("bright", "dsnn", "Avoidance-v0", "n_con")


def test_only_a_name_that_is_alike_is_the_nearest():
    typed = ("brigth", "Dsn", "avoidence-v0", "n_kon", "zqzqzq")
    assert [closest(name, KNOWN) for name in typed] == [*KNOWN, ""]
