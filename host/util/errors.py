"""Errors of the user's input or machine, as one sentence and an exit code.

Exit codes of the command: 0 done, 1 not achieved, 2 wrong use or bad input, 130 stopped by Ctrl-C,
129 and 143 by SIGHUP (the terminal is gone) and SIGTERM.
"""

NOT_ACHIEVED = 1
WRONG_USE = 2
INTERRUPTED = 130


class UserError(Exception):
    """One sentence for the user: what, where, which value, what is allowed or what to do.

    host/cli.py prints it as one line on stderr and leaves with ``exit_code``.
    """

    def __init__(self, sentence: str, exit_code: int = WRONG_USE) -> None:
        super().__init__(" ".join(sentence.split()))
        self.exit_code = exit_code
