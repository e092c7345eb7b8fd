"""The robot and its ground in other programs' formats, generated from the robot file."""
