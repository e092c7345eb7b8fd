"""Lets a child hear what ends it: what a shell starts behind it is deaf to Ctrl-C, what nohup starts to SIGHUP."""

import signal


def hear_signals():
    """For Popen's ``preexec_fn``."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
