"""Walk objects, and find attributes that no list says to be state or not."""

from collections import deque
from collections.abc import Iterator, Mapping

from dsnn.snapshot import Parts, attributes


def unlisted(value: object, parts: Parts, rest: Mapping[str, str], seen: set[int] | None = None) -> Iterator[str]:
    """Yield ``Class.attribute`` of every object whose class is in ``parts``, also of those in lists and mappings.

    ``rest`` has the attributes that are no state, by class, with its module or without.
    """
    seen = set() if seen is None else seen
    if isinstance(value, list | tuple | deque | dict):
        for one in value.values() if isinstance(value, dict) else value:
            yield from unlisted(one, parts, rest, seen)
    elif (names := attributes(value, parts)) is not None and id(value) not in seen:
        seen.add(id(value))
        for kind in type(value).__mro__:
            names += rest.get(f"{kind.__module__}.{kind.__qualname__}", rest.get(kind.__name__, "")).split()
        for name, one in vars(value).items():
            if name not in names:
                yield f"{type(value).__name__}.{name}"
            yield from unlisted(one, parts, rest, seen)
