"""People and cars among windblown foliage (the paper's real-world), in a street of our own rendering."""

from experiments import Clip, OfflineExperiment

WAYS = ("rightward", "leftward")
CAR = (("kind", "car"), ("height", 42.0), ("speed", 120.0))
"""122 px long, at the fastest of the paper's synthetic clips: 4 m/s of a car of 4.2 m, as on a campus avenue."""

EXPERIMENT = OfflineExperiment(
    name="street",
    summary="a walker, a car, two one after the other in opposite directions, a group, among windblown foliage",
    clips=(
        Clip("foliage alone", "street", (("object", "absent"),)),
        *(Clip(f"person {way}", "street", (("motion", way),)) for way in WAYS),
        *(Clip(f"car {way}", "street", (("motion", way), *CAR)) for way in WAYS),
        *(Clip(f"two, {way} first", "street", (("motion", way), ("movers", "opposite"))) for way in WAYS),
        *(Clip(f"group {way}", "street", (("motion", way), ("movers", "group"))) for way in WAYS),
    ),
    models=("dsnn",),
    claims=("C28",),
    repeats=5,
)

if __name__ == "__main__":
    EXPERIMENT.main()
