"""TIM1: counting, compare, dead time, updates, break. RM0090 section 17; expectations worked out by hand."""

import pytest

from host.sim.chip.tim_output import dead_time_ticks

from .board import (
    ARPE,
    ARR,
    BDTR,
    CCER,
    CCMR1,
    CCMR2,
    CCR1,
    CCR2,
    CCR4,
    CEN,
    CENTRE,
    CNT,
    CR1,
    CR2,
    DIER,
    EGR,
    PSC,
    RCR,
    SR,
    UG,
    clocked,
    edges,
    reasons,
    set_pin,
)

MOE, OSSI, OSSR, BKE, BKP, AOE = 0x8000, 0x400, 0x800, 0x1000, 0x2000, 0x4000
PWM1_PRELOADED, PWM2_PRELOADED = 0x68, 0x78


def timer(arr=8, mode=0x60, compare=4, ccer=1, bdtr=MOE, cr1=CENTRE | ARPE, cr2=0, rcr=0):
    """Return a chip with TIM1 set up, loaded by UG, and not started yet."""
    chip = clocked()
    for address, value in ((CR1, cr1), (CR2, cr2), (ARR, arr), (RCR, rcr), (CCMR1, mode), (CCR1, compare),
                           (CCER, ccer), (EGR, UG), (SR, 0), (BDTR, bdtr)):  # fmt: skip
        chip.write(address, value)
    chip.forgive()
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


def test_pwm_mode_2_is_the_inverse():
    one, two = timer(mode=0x60), timer(mode=0x70)
    for chip in (one, two):
        chip.write(CR1, chip.read(CR1) | CEN)
    for _ in range(40):
        assert one.tim1.ref[1] == 1 - two.tim1.ref[1]
        one.advance(1)
        two.advance(1)


def test_edge_aligned_period_is_arr_plus_one():
    """17.3.10, figure 118: ARR = 8, CCR = 4: on for 4 of 9 steps."""
    chip = timer(cr1=ARPE)
    begin = start(chip, periods=2)
    steps = [(4, "0"), (9, "1"), (13, "0"), (18, "1"), (22, "0"), (27, "1"), (31, "0")]
    assert edges(chip, "CH1") == [(begin + step, level) for step, level in steps]


def test_a_prescaler_acts_from_the_next_update():
    chip = timer()
    chip.write(PSC, 2)
    begin = start(chip, periods=4)
    times = [cycle - begin for cycle, _ in chip.tim1.boundaries]
    assert times == [8, 32, 56]  # the first half at 1 cycle a step, from the overflow on 3


@pytest.mark.parametrize(
    ("cms", "flagged"),
    [(1, [12]), (2, [4]), (3, [4, 12])],  # 17.4.1: flags going down, going up, both ways
)
def test_compare_flags_by_centre_aligned_mode(cms, flagged):
    chip = timer(cr1=cms << 5 | ARPE)
    chip.write(CR1, chip.read(CR1) | CEN)
    seen = []
    for step in range(16):
        if chip.read(SR) & 2:
            seen.append(step)
            chip.write(SR, ~2 & 0xFFFF)
        chip.advance(1)
    assert seen == flagged


def test_compare_flag_beyond_arr_comes_at_the_overflow():
    """17.4.5: CC1IF goes high at the overflow if CCR1 is greater than ARR."""
    chip = timer(compare=20)
    chip.write(CR1, chip.read(CR1) | CEN)
    chip.advance(7)
    assert not chip.read(SR) & 2
    chip.advance(1)
    assert chip.read(SR) & 2


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


@pytest.mark.parametrize(("ckd", "factor"), [(0, 1), (1, 2), (2, 4)])
def test_dead_time_delays_each_switching_on(ckd, factor):
    chip = timer(arr=100, compare=50, ccer=5, bdtr=MOE | 10, cr1=CENTRE | ARPE | ckd << 8)
    begin = start(chip, arr=100)
    dead = 10 * factor
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
    ("bdtr", "cr2", "ccer", "levels"),
    [
        (0, 0, 5, (None, None)),  # OSSI 0: not driven
        (OSSI, 0, 5, (0, 0)),
        (OSSI, 0x200, 5, (0, 1)),  # OIS1N
        (OSSI, 0x100, 5, (1, 0)),  # OIS1
        (OSSI, 0, 0, (None, None)),
        (OSSI, 0x200, 1, (0, 1)),  # one enable is enough for both to be driven
    ],
)
def test_levels_while_the_main_output_is_off(bdtr, cr2, ccer, levels):
    chip = timer(bdtr=bdtr, cr2=cr2, ccer=ccer)
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
    chip = timer(arr=100, compare=50, ccer=5, bdtr=MOE | OSSI | 20, cr2=0x200)
    start(chip, arr=100, periods=1)
    chip.forgive()
    off = chip.now
    chip.write(BDTR, OSSI | 20)
    chip.advance(50)
    assert dict(edges(chip, "CH1")) == {off: "0"}
    assert edges(chip, "CH1N") == [(off + 20, "1")]


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


def test_update_flag_by_ug_and_urs():
    """17.4.1, URS: with it UG loads the registers but sets no flag."""
    for urs, flag in ((0, 1), (4, 0)):
        chip = timer()
        chip.write(CR1, CENTRE | ARPE | urs)
        chip.write(EGR, UG)
        assert chip.read(SR) & 1 == flag


def test_udis_holds_updates_back():
    chip = timer(mode=PWM1_PRELOADED)
    chip.write(CR1, CENTRE | ARPE | 2)
    chip.write(CCR1, 2)
    chip.tim1.updates.clear()
    start(chip)
    assert chip.tim1.updates == []
    assert chip.tim1.ccr[1] == 4


def test_the_update_interrupt_comes_with_the_update():
    chip = timer(arr=1000, rcr=1)
    chip.write(DIER, 1)
    chip.write(0xE000_E100, 1 << 25)  # ISER0: interrupt 25, TIM1_UP
    begin = start(chip, arr=1000, periods=2)
    assert chip.happened("NVIC", "exception 41 pending")[0] - begin == 2000
    assert chip.pending_interrupts() == [41]


# -- triggers to the ADC --


def test_channel_4_in_mode_2_triggers_between_its_matches():
    """PWM mode 2: OC4REF rises at CCR4 going up and falls at CCR4 going down (17.3.10)."""
    chip = timer(arr=100, cr2=7 << 4)
    seen = []
    chip.trigger = lambda line, level: seen.append((chip.now, line, level))
    chip.write(CCMR2, PWM2_PRELOADED << 8)
    chip.write(CCR4, 90)
    chip.write(EGR, UG)
    seen.clear()
    begin = start(chip, arr=100, periods=1)
    assert [(c - begin, level) for c, line, level in seen if line == "TIM1_TRGO"] == [(90, 1), (110, 0)]


# -- 17.3.12: break; 17.4.18: lock --


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


def test_a_longer_dead_time_by_ckd_reaches_a_switching_under_way():
    chip = timer(arr=100, compare=50, ccer=5, bdtr=MOE | 20)
    begin = start(chip, arr=50, periods=0)
    chip.advance(60)  # OC1 went off at 50, OC1N comes on at 70
    chip.write(CR1, chip.read(CR1) | 1 << 8)
    chip.advance(40)
    assert edges(chip, "CH1N")[-1] == (begin + 90, "1")


def test_automatic_enable_waits_for_the_next_update():
    chip = broken(1, BKE | AOE)
    begin = start(chip, arr=100, periods=1)
    assert chip.read(BDTR) & MOE
    assert chip.happened("TIM1", "MOE on")[0] - begin == 100


def test_lock_protects_by_level():
    chip = timer(bdtr=0x100 | 30)  # level 1: dead time, break, OISx
    chip.write(BDTR, 0x100 | 31 | OSSI)
    assert chip.read(BDTR) == 0x100 | 30 | OSSI
    assert "locked" in reasons(chip)[0]
    chip.write(BDTR, 0x200 | 30 | OSSI)
    assert chip.read(BDTR) >> 8 & 3 == 1


def test_preloaded_enables_wait_for_a_commutation():
    """17.4.2 CCPC: CCxE and CCxNE come into force with COMG."""
    chip = timer(ccer=0, cr2=1)
    chip.write(CCER, 1)
    assert chip.tim1.out.level.get("CH1") is None
    chip.write(EGR, 0x20)
    assert chip.tim1.out.level["CH1"] == 1


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
