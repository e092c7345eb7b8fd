"""TIM1: counting, compare, dead time, updates, break. RM0090 section 17; expectations worked out by hand."""

import pytest

from host.sim.chip.tim_output import dead_time_ticks

from .board import (
    ARPE,
    ARR,
    BDTR,
    CCER,
    CCMR1,
    CCR1,
    CCR2,
    CEN,
    CENTRE,
    CNT,
    CR1,
    DIER,
    EGR,
    RCR,
    SR,
    UG,
    clocked,
    edges,
    forgive,
    reasons,
    set_pin,
)

MOE, OSSI, OSSR, BKE = 0x8000, 0x400, 0x800, 0x1000
PWM1_PRELOADED = 0x68


def timer(arr=8, mode=0x60, compare=4, ccer=1, bdtr=MOE, cr1=CENTRE | ARPE, rcr=0):
    """Return a chip with TIM1 set up, loaded by UG, and not started yet."""
    chip = clocked()
    for address, value in ((CR1, cr1), (ARR, arr), (RCR, rcr), (CCMR1, mode), (CCR1, compare),
                           (CCER, ccer), (EGR, UG), (SR, 0), (BDTR, bdtr)):  # fmt: skip
        chip.write(address, value)
    forgive(chip)
    return chip


def start(chip, periods=2, arr=8):
    """Start the counter; return the cycle of the start."""
    begin = chip.now
    chip.write(CR1, chip.read(CR1) | CEN)
    chip.advance(2 * arr * periods)
    return begin


# -- 17.3.2, figure 119: ARR = 8, PWM mode 1, centre-aligned. The counter: 0 1 2 3 4 5 6 7 8 7 6 5 4 3 2 1 | 0 --


def test_the_counter_runs_up_and_down():
    chip = timer()
    chip.write(CR1, chip.read(CR1) | CEN)
    seen = []
    for _ in range(18):
        seen.append((chip.read(CNT), chip.read(CR1) >> 4 & 1))
        chip.advance(1)
    counts = [0, 1, 2, 3, 4, 5, 6, 7, 8, 7, 6, 5, 4, 3, 2, 1, 0, 1]
    assert [count for count, _ in seen] == counts
    assert [down for _, down in seen] == [0] * 8 + [1] * 8 + [0] * 2


@pytest.mark.parametrize(
    ("compare", "high"),
    [
        (4, "1111000000001111"),  # figure 119: off from 4 going up, on again at 4 going down
        (7, "1111111001111111"[:7] + "00" + "1111111"),
        (8, "1" * 16),
        (9, "1" * 16),
        (0, "0" * 16),
        (1, "1000000000000001"),
    ],
)
def test_reference_of_pwm_mode_1_in_centre_aligned_mode(compare, high):
    chip = timer(compare=compare)
    chip.write(CR1, chip.read(CR1) | CEN)
    seen = ""
    for _ in range(16):
        seen += str(chip.tim1.ref[1])
        chip.advance(1)
    assert seen == high


# -- 17.4.18: dead time --


@pytest.mark.parametrize(
    ("code", "steps"),
    [(0, 0), (0x7F, 127), (0x80, 128), (0xBF, 254), (0xC0, 256), (0xDF, 504), (0xE0, 512), (0xFF, 1008)],
)
def test_dead_time_codes_join_up(code, steps):
    assert dead_time_ticks(code) == steps


def test_dead_time_codes_never_fall():
    table = [dead_time_ticks(code) for code in range(256)]
    assert table == sorted(table)
    assert len(set(table)) == 256


def test_dead_time_delays_each_switching_on():
    chip = timer(arr=100, compare=50, ccer=5, bdtr=MOE | 10)
    begin = start(chip, arr=100)
    dead = 10
    main, negative = dict(edges(chip, "CH1")), dict(edges(chip, "CH1N"))
    assert main[begin + 50] == "0"
    assert negative[begin + 50 + dead] == "1"
    assert negative[begin + 150] == "0"
    assert main[begin + 150 + dead] == "1"
    assert not [reason for reason in reasons(chip) if "shoot" in reason]


def test_a_pulse_shorter_than_the_dead_time_is_left_out():
    """Figure 122: OCx does not switch on when the pulse is shorter than the delay."""
    chip = timer(arr=100, compare=3, ccer=5, bdtr=MOE | 10)  # the pulse lasts 6
    start(chip, arr=100)
    assert not [level for _, level in edges(chip, "CH1") if level == "1"]
    assert [level for _, level in edges(chip, "CH1N")].count("1") >= 1


def test_wrong_polarity_is_shoot_through():
    chip = timer(arr=100, compare=50, ccer=5 | 8)  # CC1NP: the low side is on when the pin is low, so high together
    start(chip, arr=100)
    assert any("shoot-through" in reason for reason in reasons(chip))


# -- table 94: outputs while MOE is off --


@pytest.mark.parametrize(
    ("bdtr", "ccer", "levels"),
    [
        (0, 5, (None, None)),  # OSSI 0: not driven
        (OSSI, 5, (0, 0)),
        (OSSI, 0, (None, None)),
        (OSSI, 1, (0, 0)),  # one enable is enough for both to be driven
    ],
)
def test_levels_while_the_main_output_is_off(bdtr, ccer, levels):
    chip = timer(bdtr=bdtr, ccer=ccer)
    chip.advance(100)
    assert (chip.tim1.out.level.get("CH1"), chip.tim1.out.level.get("CH1N")) == levels


def test_idle_levels_that_are_both_on_are_told_and_kept_off():
    chip = timer(bdtr=0, ccer=5 | 0xA)  # active low, and both OIS are 0
    chip.write(BDTR, OSSI)
    assert (chip.tim1.out.level["CH1"], chip.tim1.out.level["CH1N"]) == (1, 1)
    assert "both on" in reasons(chip)[0]


@pytest.mark.parametrize(("ossr", "ccer", "levels"), [(0, 1, (1, None)), (OSSR, 1, (1, 0)), (OSSR, 4, (0, 1))])
def test_one_enabled_output_and_ossr(ossr, ccer, levels):
    """Table 94: alone, OCxN follows OCxREF and is not its complement; OSSR drives the other one inactive."""
    chip = timer(bdtr=MOE | ossr, ccer=ccer)
    assert chip.tim1.ref[1] == 1
    assert (chip.tim1.out.level.get("CH1"), chip.tim1.out.level.get("CH1N")) == levels


def test_idle_levels_come_after_the_dead_time():
    chip = timer(arr=100, compare=50, ccer=5 | 8, bdtr=MOE | OSSI | 20)  # CC1NP: on is low, and off high
    start(chip, arr=100, periods=1)
    forgive(chip)
    off = chip.now
    chip.write(BDTR, OSSI | 20)
    chip.advance(50)
    assert dict(edges(chip, "CH1")) == {off: "0"}
    assert edges(chip, "CH1N") == [(off + 20, "0")]


# -- 17.3.3: repetition counter and updates --


@pytest.mark.parametrize(
    ("rcr", "first_updates"),
    [
        (0, [(8, "top"), (16, "bottom"), (24, "top")]),
        (1, [(16, "bottom"), (32, "bottom")]),
        (2, [(24, "top"), (48, "bottom"), (72, "top")]),  # even: top and bottom in turn
        (3, [(32, "bottom"), (64, "bottom")]),
    ],
)
def test_updates_after_ug_loaded_the_repetition_counter(rcr, first_updates):
    chip = timer(rcr=rcr)
    chip.tim1.updates.clear()
    begin = start(chip, periods=5)
    assert [(cycle - begin, where) for cycle, where in chip.tim1.updates][: len(first_updates)] == first_updates


def test_rcr_written_but_not_loaded_gives_updates_at_the_top():
    """The buffer is loaded by the first overflow, which is an update itself; every second event follows."""
    chip = timer(rcr=0)
    chip.tim1.updates.clear()
    chip.write(RCR, 1)
    begin = start(chip, periods=4)
    assert [(c - begin, w) for c, w in chip.tim1.updates] == [(8, "top"), (24, "top"), (40, "top"), (56, "top")]


def test_odd_repetition_is_marked_as_open():
    chip = timer(rcr=1)
    start(chip)
    assert [doubt.register for doubt in chip.doubts] == ["RCR"]
    chip = timer(rcr=0)
    start(chip)
    assert chip.doubts == []


def test_a_preloaded_compare_acts_at_the_update_and_a_plain_one_at_once():
    chip = timer(arr=100, mode=PWM1_PRELOADED, compare=50, rcr=1)
    begin = start(chip, arr=100, periods=1)
    chip.advance(30)
    chip.write(CCR1, 20)
    chip.advance(400)
    channel, value, written, acts = chip.tim1.effects[-1]
    assert (channel, value, written - begin, acts - begin) == (1, 20, 230, 400)
    assert (begin + 420, "0") in edges(chip, "CH1")
    chip.write(CCMR1, 0x60)
    chip.write(CCR1, 70)
    assert chip.tim1.ccr[1] == 70


def test_the_update_interrupt_comes_with_the_update():
    chip = timer(arr=1000, rcr=1)
    chip.write(DIER, 1)
    chip.write(0xE000_E100, 1 << 25)  # ISER0: interrupt 25, TIM1_UP
    begin = start(chip, arr=1000, periods=2)
    assert next(cycle - begin for cycle, _, told in chip.events if told == "exception 41 pending") == 2000
    assert chip.pending_interrupts() == [41]


# -- 17.3.12: break --


def broken(level, bdtr):
    """Return a chip whose break input is on PB12 at a level."""
    chip = timer(arr=100, compare=50, ccer=5, bdtr=0)
    set_pin(chip, "PB12", 2, 1)
    chip.pins.drive_pin("PB12", level)
    chip.write(BDTR, bdtr)
    return chip


def test_a_break_turns_the_outputs_off_at_once_and_holds_them_off():
    chip = broken(1, MOE | BKE | OSSI)  # BKP 0: active low
    start(chip, arr=100, periods=1)
    chip.pins.drive_pin("PB12", 0)
    assert not chip.read(BDTR) & MOE
    assert chip.read(SR) & 0x80
    chip.write(BDTR, MOE | BKE | OSSI)
    assert not chip.read(BDTR) & MOE
    chip.write(SR, 0)
    assert chip.read(SR) & 0x80  # 17.4.5: BIF cannot be cleared while the break is active
    chip.pins.drive_pin("PB12", 1)
    chip.write(SR, 0)
    chip.write(BDTR, MOE | BKE | OSSI)
    assert chip.read(BDTR) & MOE


def test_a_break_without_a_pin_or_on_a_floating_one_is_told():
    chip = timer(bdtr=0)
    chip.write(BDTR, BKE)
    set_pin(chip, "PB12", 2, 1)
    chip.write(BDTR, BKE)
    assert "TIM1_BKIN: no pin" in reasons(chip)[0]
    assert "PB12 floats" in reasons(chip)[1]


def test_both_channels_keep_their_own_compare():
    chip = timer(arr=10, mode=0x6060, ccer=0x11)
    chip.write(CCR2, 7)
    begin = start(chip, arr=10, periods=1)
    assert (begin + 4, "0") in edges(chip, "CH1")
    assert (begin + 7, "0") in edges(chip, "CH2")


def test_a_compare_value_overwritten_before_the_update_never_acts():
    chip = timer(arr=100, mode=PWM1_PRELOADED, compare=50)
    begin = start(chip, arr=100, periods=1)
    chip.write(CCR1, 20)
    chip.advance(10)
    chip.write(CCR1, 30)
    chip.advance(200)
    assert chip.tim1.effects[-1] == (1, 30, begin + 210, begin + 300)
    assert chip.tim1.effects[-2][1] == 50


@pytest.mark.parametrize(
    ("address", "word", "told"),
    [
        (CR1, CEN | ARPE, "only centre-aligned"),
        (CCMR1, 0x70, "only PWM mode 1"),
        (CCER, 0x1000, "not modelled"),  # a fourth channel
        (BDTR, 0x100, "not modelled"),  # LOCK
    ],
)
def test_what_is_not_modelled_is_told(address, word, told):
    chip = timer()
    chip.write(address, word)
    assert told in reasons(chip)[0]
