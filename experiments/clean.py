"""Objects on an even ground (the paper's simu-clean): four translations, looming and receding, dark and light."""

from experiments import Clip, OfflineExperiment

GREYS = {"dark": (40.0, 200.0), "light": (200.0, 40.0)}
"""Object and ground: the golden vectors' greys, and the same exchanged."""
LONG_EDGE_AHEAD = {
    "rightward": (50.0, 90.0),
    "leftward": (50.0, 90.0),
    "downward": (90.0, 50.0),
    "upward": (90.0, 50.0),
}
"""The rectangle is turned for the vertical motions: what moves is as long an edge."""


def _clip(shade: str, motion: str) -> Clip:
    grey, ground = GREYS[shade]
    width, height = LONG_EDGE_AHEAD.get(motion, (50.0, 90.0))
    changes = {"motion": motion, "grey": grey, "background_grey": ground, "width": width, "height": height}
    return Clip(f"{shade} {motion}", "plain", changes)


EXPERIMENT = OfflineExperiment(
    name="clean",
    summary="dark and light objects translate, loom and recede on an even ground",
    clips=tuple(_clip(shade, motion) for shade in GREYS for motion in (*LONG_EDGE_AHEAD, "looming", "receding")),
    models=("dsnn",),
    claims=("C1", "C2", "C3"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
