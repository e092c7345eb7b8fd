"""Lets a child process hear Ctrl-C: a shell's background job, and so its children, is started deaf to it."""

import signal


def hear_ctrl_c():
    """For Popen's ``preexec_fn``."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
