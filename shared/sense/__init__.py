"""What is sensed, and what is made of it."""
