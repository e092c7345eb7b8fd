"""Where the robot has walked to, in SI, from the core's legs and gyroscope (shared/sense/odometry.py)."""

from dataclasses import dataclass
from math import degrees, pi, sqrt

from shared.body.params import LF_BITS, Params
from shared.sense import odometry as core

TURN = 1 << 24  # the core's heading
FINE_RAD = 1 << 24  # of its turning speed
SIGMA_RAD = 1 << 26


@dataclass(frozen=True)
class Odometry:
    """Where the body is, x ahead and y left of where it stood at the start, and how fast it moves.

    Position in m, yaw in rad (positive to the left, not wrapped), velocities in the body's own axes, m/s and rad/s.
    ``covariance``: 3 x 3 by rows, of x, y and yaw; m2, m rad, rad2.
    """

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    vx_m_s: float = 0.0
    vy_m_s: float = 0.0
    wz_rad_s: float = 0.0
    covariance: tuple[float, ...] = (0.0,) * 9

    @property
    def sigma(self) -> tuple[float, float, float]:
        """Standard deviations of x and y, m, and of the yaw, rad; 95 of 100 walks end within twice as much."""
        return sqrt(self.covariance[0]), sqrt(self.covariance[4]), sqrt(self.covariance[8])

    def __str__(self) -> str:
        return f"x {self.x_m:.3f} m, y {self.y_m:.3f} m, yaw {degrees(self.yaw_rad):.1f} deg"


def read_odometry(params: Params, block: core.Odometry) -> Odometry:
    """Return the core's block as an Odometry, for the robot with these parameters."""
    core.odometry_spread(params, block)
    unit_m, hertz = 1 / (1 << params.length_shift), params.rate_hz
    fine_m = unit_m / (1 << LF_BITS)
    yaw_rad = 2 * pi * (block.turns + block.heading / TURN)
    ahead, aside = block.speed.x * fine_m * hertz, block.speed.y * fine_m * hertz
    turning = block.turning / FINE_RAD * hertz
    place_m = block.place.x * unit_m, block.place.y * unit_m
    return Odometry(*place_m, yaw_rad, ahead, aside, turning, _covariance(block, unit_m, fine_m))


def _covariance(block: core.Odometry, unit_m: float, fine_m: float) -> tuple[float, ...]:
    """Return s s' + g g' and a^2 for x and y, as shared/sense/odometry.py has it, by rows."""
    scale_spread = block.scale_spread.x * unit_m, block.scale_spread.y * unit_m, 0.0
    by_heading = block.heading_spread
    heading_spread = by_heading.x * fine_m, by_heading.y * fine_m, block.heading_sigma_q26 / SIGMA_RAD
    place_spread = [(block.place_spread * unit_m) ** 2] * 2 + [0.0]
    return tuple(
        scale_spread[i] * scale_spread[j] + heading_spread[i] * heading_spread[j] + (place_spread[i] if i == j else 0.0)
        for i in range(3) for j in range(3)
    )  # fmt: skip
