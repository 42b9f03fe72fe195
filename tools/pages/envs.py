"""Pages: a page for each env, which is its class's docstring."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path

from colias_sim.envs import ENVS

_HEAD = """# {name}

```python
import colias_sim  # registers the envs
import gymnasium as gym

env = gym.make("{name}")
```

:::{{py:class}} {module}.{cls}(**arguments)
A [ColiasEnv](../api/colias_sim.envs.base.ColiasEnv.rst): that page has its methods.
:::

"""


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    titles = []
    for name, entry in ENVS.items():
        module, _, cls = entry.entry_point.partition(":")
        page = inspect.getdoc(getattr(importlib.import_module(module), cls)) or ""
        titles.append(cls.lower())
        head = _HEAD.format(name=name, module=module, cls=cls)
        (folder / f"{titles[-1]}.md").write_text(f"{head}{page}\n", encoding="utf-8")
    toctree = "\n".join([":::{toctree}", *titles, ":::"])
    rows = [f"| [{name}]({title}.md) | {entry.summary} | {entry.max_episode_steps} |"
            for (name, entry), title in zip(ENVS.items(), titles, strict=True)]  # fmt: skip
    table = "\n".join(["| env | task | steps |", "|---|---|---|", *rows])
    (folder / "index.md").write_text(f"# Envs\n\n{table}\n\n{toctree}\n", encoding="utf-8")
