"""What every folder of the host may use: errors, files, processes, the console."""
