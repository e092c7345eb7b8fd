"""The trot: diagonals in turn without a pause, footholds where the measured speed wants them."""
