"""Sensor readings and what follows from them: attitude, what the legs feel, odometry."""
