"""Which robots this software drives, and what it says of the others."""

import pytest

from host.control.hardware import real
from host.robot.file import driven_names, load_robot, robot_names
from host.util.errors import UserError


@pytest.mark.parametrize("name", sorted(set(robot_names()) - set(driven_names())))
def test_a_robot_that_is_simulated_only_is_not_driven(name):
    with pytest.raises(UserError, match=f"{name}: can only be simulated, not driven"):
        real(load_robot(name), None, None)
