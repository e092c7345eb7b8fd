"""Which servo is which joint, which way it turns and where its zero is: the data of one robot, and how to find it."""
