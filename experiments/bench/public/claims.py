"""The claim that a file of one's own declares about trials with the robot, by its public name."""

from experiments.bench.sources.robot_claims import RobotClaim as Claim

__all__ = ["Claim"]
