"""The words by which a board tells how its start went; the host knows them too."""

STARTED = "firmware started from slot"  # said when the application gets the board

CHOSEN = "chosen"
RUNNING = "running"
STOPPED = "stopped"
FAILED = "failed"
