"""The documentation of the envs names what is there."""

import inspect
import re

from colias_sim import envs
from colias_sim.envs.senses import MANOEUVRES
from tests.helpers.envs import bare, episode, every_env

SHARED = inspect.getdoc(envs) or ""


@every_env
def test_every_entry_of_info_is_documented(name):
    env = bare(name, observation="state")
    page = SHARED + (inspect.getdoc(type(env)) or "")
    *_, info = episode(env, seed=0)[1]
    for key in info:
        assert f"`{key.removeprefix('reward_')}`" in page, key


def test_the_table_of_manoeuvres_is_theirs():
    rows = re.findall(r"^\| \d \| (\D+) \| (-?0\.\d) \| (-?0\.\d) \|$", SHARED, re.MULTILINE)
    assert {name: (float(left), float(right)) for name, left, right in rows} == MANOEUVRES
