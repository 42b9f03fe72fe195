"""Checks of what draws: in a process of its own, as MuJoCo's backend is chosen once a process, and may break it."""

from __future__ import annotations

import base64
import json
import subprocess
import sys
from typing import Any

from experiments.bench.doctor.finding import Finding
from experiments.bench.run.streams import stream

FRAMES = 30
"""Frames by which the camera is timed."""
PATIENCE_S = 120.0
REMEDY = "unset the variable of OpenGL that is named, or on Debian or Ubuntu: apt-get install libegl1 libgl1"


def drawing() -> list[Finding]:
    """Draw the reference frame, compare it with the known ones, and time the robot's camera."""
    command = [sys.executable, "-P", "-m", "experiments.bench.doctor.picture"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    except (OSError, subprocess.SubprocessError) as error:
        return [Finding("rendering", "fails", f"no answer: {type(error).__name__}", REMEDY)]
    try:
        measured = json.loads(done.stdout.splitlines()[-1])
    except (ValueError, IndexError):
        last = (done.stderr.strip().splitlines() or [f"ended with status {done.returncode}"])[-1]
        return [Finding("rendering", "fails", last[:300], REMEDY)]
    if "trouble" in measured:
        return [Finding("rendering", "fails", measured["trouble"], REMEDY)]
    return [_renderer(measured), _pixels(measured), _camera(measured)]


def _renderer(measured: dict[str, Any]) -> Finding:
    renderer = measured["renderer"]
    if not measured["software"]:
        return Finding("renderer", "ok", renderer)
    return Finding("renderer", "ok", f"{renderer}: software, no graphics processor draws")


def _camera(measured: dict[str, Any]) -> Finding:
    text = f"{measured['camera_ms']:.2f} ms a frame of 99x72, physics included"
    if measured["software"]:
        text += "; what drawing in software costs is in this number"
    return Finding("robot's camera", "ok", text)


def _pixels(measured: dict[str, Any]) -> Finding:
    if measured["known"]:
        return Finding("reference frame", "ok", f"{measured['hash']}, as on {measured['known']}")
    apart, count = measured["largest"], measured["differing"]
    text = (
        f"{measured['hash']} is not known: the largest difference is {apart} of 255 grey levels, in {count} of"
        f" {measured['pixels']} values"
    )
    return Finding("reference frame", "notice", text, "numbers may differ from the documented ones: compare seeds here")


def _probe() -> dict[str, Any]:
    """Return what the process of its own finds; ``trouble`` alone where it cannot draw."""
    try:
        import time

        import cv2
        import numpy as np

        from colias_sim import CameraConfig, Pose, SceneConfig, Simulation, gl, reference
    except Exception as error:
        return {"trouble": " ".join(f"{error}".split()) or type(error).__name__}
    try:
        frame = reference.reference_frame()
        with Simulation(camera=CameraConfig(), scene=SceneConfig()) as simulation:
            draw = stream("doctor.frames", 0)
            simulation.reset({"stimulus": Pose(0.1, 0.0, 0.0)}, draw)
            simulation.step(draw)
            begun = time.perf_counter()
            for _ in range(FRAMES):
                simulation.step(draw)
            spent = 1e3 * (time.perf_counter() - begun) / FRAMES
    except Exception as error:
        return {"trouble": " ".join(f"{error}".split()) or type(error).__name__}
    apart = np.abs(frame.astype(int) - reference.expected_frame().astype(int))
    hash_ = reference.digest(frame)
    _, coded = cv2.imencode(".png", cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
    return {
        "renderer": gl.renderer(), "software": gl.is_software(gl.renderer()),
        "hash": hash_, "known": reference.KNOWN.get(hash_, ""),
        "largest": int(apart.max()), "differing": int((apart > 0).sum()), "pixels": int(apart.size),
        "camera_ms": spent, "png": base64.b64encode(coded.tobytes()).decode(),
    }  # fmt: skip


if __name__ == "__main__":
    print(json.dumps(_probe()))
