"""Runs the encoder on checked integers at every turn count of the position's range and at the seams of all others.

A process of its own: checked integers replace `array` and all of shared/, so nothing of it may be imported before.
Prints what is wrong first, if anything is, and how many turn counts were tried.
"""

from host.lab.parity import checked

MOST = (1 << 30) - 2  # turns
IN_POSITION = 32766
ZERO = 5000


def wanted(turns, fraction, sign):
    """Return (turns, fraction, position) in plain arithmetic."""
    turns = max(-MOST, min(MOST, turns))
    if abs(turns) > IN_POSITION:
        return turns, fraction, ((1 << 29) - 1) * (sign if turns > 0 else -sign)
    return turns, fraction, sign * (turns * 16384 + fraction - ZERO)


def step(encoder, blocks, turns, sign, moved):
    """One tick from ``turns`` turns and a fraction near the end that ``moved`` crosses."""
    loop, settings, state = blocks
    fraction = 16000 if moved > 0 else 300
    state.turns, state.fraction, settings.joint_sign = turns, fraction, sign
    loop.rotor = (fraction + moved) & 16383
    position = encoder.encoder_step(loop, settings, state)
    found = state.turns, state.fraction, position
    expected = wanted(turns + (fraction + moved >> 14), (fraction + moved) & 16383, sign)
    assert found == expected, f"{turns} turns, {moved} on: {found} instead of {expected}"


def choose(encoder, blocks, turns, sign):
    """Choose the turn for an expected position in turn ``turns``."""
    _, settings, state = blocks
    state.fraction, settings.joint_sign = 900, sign
    expected = sign * (turns * 16384 + 900 - ZERO)
    left = encoder.choose_turn(settings, state, checked.check(expected))
    found = left, state.turns, state.position
    assert found == (0, turns, expected), f"choosing {turns} turns: {found}"


def main():
    checked.install()
    from shared.joint import encoder
    from shared.joint.layout import CurrentLoop, JointSettings, JointState

    blocks = CurrentLoop(), JointSettings(), JointState()
    blocks[1].zero = ZERO
    seams = checked.seams("shared.joint.encoder", -MOST, MOST)
    for turns in seams:
        for sign, moved in ((1, 700), (-1, 700), (1, -700), (-1, -700)):
            step(encoder, blocks, turns, sign, moved)
            if abs(turns) < 1 << 14:
                choose(encoder, blocks, turns, sign)
    for turns in range(-IN_POSITION - 4, IN_POSITION + 5):
        step(encoder, blocks, turns, *((1, 700) if turns & 1 else (-1, -700)))
        if abs(turns) < 1 << 14:
            choose(encoder, blocks, turns, 1 if turns & 1 else -1)
    print(f"{len(seams) + 2 * IN_POSITION + 9} turn counts")


if __name__ == "__main__":
    main()
