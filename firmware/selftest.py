"""Self-test of a firmware after its start: the core's arithmetic on this processor against known answers."""

from shared.num.fixed import atan2_brad, cos_q15, isqrt, mul_q15, sin_q15


def self_test():
    """Return "" if all is well, else what is wrong."""
    # A wrong processor or a torn table shows here. The answers are the core's on every other runtime, to the bit.
    answers = (
        ("sin_q15(0x2000)", sin_q15(0x2000), 23171),
        ("sin_q15(0xC000)", sin_q15(0xC000), -32767),
        ("cos_q15(0x8000)", cos_q15(0x8000), -32767),
        ("mul_q15(-16384, 16384)", mul_q15(-16384, 16384), -8192),
        ("isqrt(2 ** 29 - 1)", isqrt(536870911), 23170),
        ("atan2_brad(1000, -1000)", atan2_brad(1000, -1000), 0x6000),
    )
    for call, answer, right in answers:
        if answer != right:
            return f"{call} is {answer}, not {right}"
    return ""
