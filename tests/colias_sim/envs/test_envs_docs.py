"""The envs' pages: their docstrings are whole, and say what is."""

import inspect
import re

from colias_sim.envs import ENVS
from colias_sim.envs.factors import FACTORS
from colias_sim.envs.options import options_of
from tests.helpers.envs import bare, env_class, episode, every_env, options_type


@every_env
def test_the_docstring_is_a_whole_page(name):
    page = inspect.getdoc(env_class(name)) or ""
    titles = re.findall(r"^## (.+)$", page, re.M)
    assert titles == [
        "Description", "Action Space", "Observation Space", "Rewards", "Info", "Starting State", "Episode End",
        "Arguments", "Version History",
    ]  # fmt: skip
    assert not re.search(r"<[A-Z]+>|\{\w*\}", page), "a placeholder"
    assert not re.search(r"^ +[#|]", page, re.M), "an indented title or table"
    assert f"{ENVS[name].max_episode_steps} steps" in page
    for option, field in options_of(options_type(name)).items():
        (row,) = re.findall(rf"^\| `{option}` \| `(.+?)` \| (.+?) \| (.+) \|$", page, re.M)
        assert row[0].replace('"', "'") == repr(field.default)
    for factor in FACTORS.values():
        row = f"| `{factor.name}` | {factor.unit} | {factor.low:g} .. {factor.high:g} | {factor.changes} |"
        assert row in page.splitlines()
    env = bare(name, observation="state")
    *_, info = episode(env, seed=0)[1]
    env.close()
    for key in info:
        documented_key = key.removeprefix("reward_")
        assert f"`{documented_key}`" in page, f"info's {key}"
