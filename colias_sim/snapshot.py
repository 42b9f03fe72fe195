"""What of a simulation and of an env is state: what goes on from frame to frame, and differs between episodes."""

from __future__ import annotations

from dsnn.snapshot import Parts

PARTS: Parts = {
    "colias_sim.simulation.Simulation": "wall_turn robots parked cameras",
    "colias_sim.robot.Robot": "_eased _motors _board",
    "colias_sim.robot.ParkedRobot": "pose",
    "colias_sim.motors.Motors": "_inequality",
    "colias_sim.motors.MotorBoard": "_waiting _running _ends _begun _line_free",
    "colias_sim.camera.Camera": "config _last _exposure_ms _planned _next_planned _sensor rays",
    "colias_sim.truth.Rays": "_begun _notes _pictures",
    "colias_sim.sensor.Sensor": "_light _ahead _exposures",
    "colias_sim.path.PathFollower": "_tracker _clock _since _ramp _surplus _at _last _moved",
    "colias_sim.path.Tracker": "index within offset along",
    "colias_sim.path.OpenLoop": "_time _sent",
    "colias_sim.envs.scripted.Wander": "_rng _turn _avoiding",
    "colias_sim.envs.scripted.Orbit": "_rng _left _speed _wanted",
    "colias_sim.envs.world.World": "_command _sent _drift _driven _touched _here",
    "colias_sim.envs.base.ColiasEnv": "_np_random _np_random_seed _start _factors _film _drivers _luma _wheels"
    " _wheel_gains _begun _running",
}
"""Class -> its state, as in `dsnn.snapshot.PARTS`. `SCENE` and MuJoCo's own state belong to the `Simulation`."""

SCENE = "light_ambient", "light_diffuse", "body_pos", "body_quat"
"""What of the compiled scene a trial changes: lamps, the wall, parked robots. An `Apparatus` repeats the other changes
from an episode's draw."""

SETTINGS = (
    "options render_mode metadata spec observation_space action_space _camera _robot _fastest _half_view _made_with"
    " _kind _renderer _apparatus _body _closed _sim _observer _hull _model _responses _events"
)
"""Attributes of an env that are no state, or are saved by their own methods. All that a subclass adds is state."""
