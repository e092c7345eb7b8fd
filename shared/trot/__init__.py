"""The trot: diagonals swing in turn without a pause, to footholds that follow from the measured speed."""
