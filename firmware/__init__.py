"""What runs on the boards: applications, chip drivers and boards. Imports shared/ and nothing else."""
