"""Which servo is which joint, which way it turns and where its zero is: one robot's data, and how to find them."""
