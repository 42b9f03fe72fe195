"""Settings that a camera can take anew after it was made."""

from __future__ import annotations

from colias_sim.config import CameraConfig

BUILT_IN = (
    "width", "height", "hfov_deg", "fps", "forward_cm", "up_cm", "multisample", "supersample", "supersample_columns",
    "still_background", "exposure_samples",
)  # fmt: skip
"""The settings that a camera cannot take anew: scene and framebuffer were made for them."""


def check_tunable(config: CameraConfig, made_with: CameraConfig, *, lamps: bool, bands: bool) -> None:
    """Check that a camera can take other settings: of noise, lens, times, luma and the exposure loop's parameters.

    Parameters
    ----------
    config
        The settings to take.
    made_with
        The settings that the camera has.
    lamps
        Whether it was made to see lamps stronger or weaker than they are: for ``auto_exposure`` and ``gain``.
    bands
        Whether it was made to render bands of rows.

    Raises
    ------
    ValueError
        For settings that need another framebuffer or another scene.
    """
    for name in BUILT_IN:
        if getattr(config, name) != getattr(made_with, name):
            raise ValueError(f"{name}={getattr(config, name)}: this camera was made with {getattr(made_with, name)}")
    if not lamps and (config.auto_exposure or config.gain != 1.0):
        raise ValueError("auto_exposure and gain: this camera was made without either")
    if not bands and config.row_time_us > 0.0:
        raise ValueError(f"row_time_us={config.row_time_us:g}: this camera was made with a global shutter")
