"""What ends a drive: Ctrl-C, SIGTERM, a terminal that goes away; not a SIGHUP that nohup has silenced."""

import signal

import pytest

from host.teleop.leaving import Leaving


@pytest.mark.parametrize(("hangs_up", "asked"), [(signal.default_int_handler, 3), (signal.SIG_IGN, 2)])
def test_a_signal_counts_unless_nohup_has_silenced_it(hangs_up, asked):
    before = signal.signal(signal.SIGHUP, hangs_up)
    again = []
    try:
        with Leaving(lambda: again.append("let go")) as leaving:
            for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT):
                signal.raise_signal(number)
        assert leaving.asked == asked
        assert len(again) == asked - 1
        assert signal.getsignal(signal.SIGHUP) == hangs_up
    finally:
        signal.signal(signal.SIGHUP, before)
