"""Workers for trials: this process, processes of this computer, or those of a lab's machines."""
