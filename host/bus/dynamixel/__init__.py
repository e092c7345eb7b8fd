"""Dynamixel MX-28 servos on a half-duplex bus, through dynamixel-sdk."""
