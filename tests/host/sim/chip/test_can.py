"""CAN1: RM0090 section 32; frame lengths by ISO 11898-1."""

import pytest

from host.sim.chip.can_wire import Frame, bits_of, crc, duration_bits, stuffed

from .board import CAN1, clocked, reasons, set_pin

MCR, MSR, TSR, RF0R, RF1R, IER, ESR, BTR = (CAN1 + 4 * n for n in range(8))
TI0R, RI0R, RI1R = CAN1 + 0x180, CAN1 + 0x1B0, CAN1 + 0x1C0
FMR, FM1R, FS1R, FFA1R, FA1R, F0R1 = (CAN1 + n for n in (0x200, 0x204, 0x20C, 0x214, 0x21C, 0x240))
INRQ, SLEEP, TXFP, RFLM, NART, ABOM = 1, 2, 4, 8, 16, 64
# 42 MHz / 3 / (1 + 10 + 3) = 1 Mbit/s, sampled at 11 / 14
MEGABIT = 2 | 9 << 16 | 2 << 20 | 0 << 24
MICROSECOND = 168
LOOP_BACK, SILENT = 1 << 30, 1 << 31


def until(chip, condition, limit_us=20_000):
    begin = chip.now
    while not condition():
        assert chip.now - begin < limit_us * MICROSECOND
        chip.advance(10)


def controller(mcr=0, btr=MEGABIT, bank=(0, 0)):
    """Return a chip with CAN1 on the bus; filter 0 takes everything unless told otherwise."""
    chip = clocked()
    set_pin(chip, "PB8", 2, 9)
    set_pin(chip, "PB9", 2, 9)
    chip.write(MCR, INRQ | mcr)
    until(chip, lambda: chip.read(MSR) & 1)
    chip.write(BTR, btr)
    filters(chip, [(True, False, 0, *bank)])
    chip.write(MCR, mcr)
    until(chip, lambda: not chip.read(MSR) & 1)
    return chip


def filters(chip, banks):
    """Set banks of (wide, listed, FIFO, first register, second register)."""
    chip.write(FMR, chip.read(FMR) | 1)
    chip.write(FA1R, 0)
    for address, column in ((FS1R, 0), (FM1R, 1), (FFA1R, 2)):
        chip.write(address, sum(bank[column] << n for n, bank in enumerate(banks)))
    for n, bank in enumerate(banks):
        chip.write(F0R1 + 8 * n, bank[3])
        chip.write(F0R1 + 8 * n + 4, bank[4])
    chip.write(FA1R, (1 << len(banks)) - 1)
    chip.write(FMR, chip.read(FMR) & ~1)


def post(chip, box, identifier, data=b"\x01\x02"):
    """Write a standard frame into a mailbox and ask for it."""
    base = TI0R + 16 * box
    word = int.from_bytes(data.ljust(8, b"\0"), "little")
    chip.write(base + 4, len(data))
    chip.write(base + 8, word & 0xFFFF_FFFF)
    chip.write(base + 12, word >> 32)
    chip.write(base, identifier << 21 | 1)


# -- frames --


def test_the_checksum_of_a_known_frame():
    """The check word of ISO 11898-1 CRC-15 over "123456789" is 0x059E (catalogue of CRC algorithms)."""
    assert crc([byte >> n & 1 for byte in b"123456789" for n in reversed(range(8))]) == 0x059E


def test_stuff_bits_follow_five_equal_bits_and_count_themselves():
    assert stuffed([0] * 5) == [0] * 5 + [1]
    assert stuffed([0, 0, 0, 0, 0, 1, 1, 1, 1]) == [0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 0]


def test_frame_lengths_lie_between_the_bounds():
    """44 + 8 n bits without stuff bits, and at most (34 + 8 n - 1) // 4 more; with 29 bits 64 and 54."""
    for n in range(9):
        for byte in (0x00, 0x55, 0xFF, 0x0F):
            short = duration_bits(Frame(0x123, bytes([byte] * n)))
            assert 44 + 8 * n <= short <= 44 + 8 * n + (34 + 8 * n - 1) // 4
            long = duration_bits(Frame(0x1234567, bytes([byte] * n), extended=True))
            assert 64 + 8 * n <= long <= 64 + 8 * n + (54 + 8 * n - 1) // 4
    assert len(bits_of(Frame(0x555, b"\x55"))) >= 34 + 8


# -- 32.4: modes; 32.7.7: bit timing --


def test_the_chip_wakes_asleep_and_shakes_hands():
    chip = clocked()
    set_pin(chip, "PB8", 2, 9)
    set_pin(chip, "PB9", 2, 9)
    assert chip.read(MSR) & 3 == 2
    chip.write(MCR, INRQ)
    assert not chip.read(MSR) & 1  # not yet
    chip.advance(10)
    assert chip.read(MSR) & 3 == 1
    chip.write(BTR, MEGABIT)
    chip.write(MCR, 0)
    chip.advance(10 * MICROSECOND)
    assert chip.read(MSR) & 1  # 11 recessive bits, 11 us, are not over
    chip.advance(1 * MICROSECOND + 10)
    assert chip.read(MSR) & 3 == 0
    assert chip.complaints == []


def test_without_a_pin_for_the_receiver_it_is_told():
    chip = clocked()
    chip.write(MCR, INRQ)
    chip.advance(10)
    chip.write(MCR, 0)
    assert "CAN1_RX: no pin" in reasons(chip)[0]


def test_a_dominant_bus_keeps_the_chip_in_initialization():
    chip = clocked()
    set_pin(chip, "PB8", 2, 9)
    set_pin(chip, "PB9", 2, 9)
    chip.can1.wire.stuck = True
    chip.write(MCR, INRQ)
    chip.advance(10)
    chip.write(MCR, 0)
    chip.advance(100_000)
    assert chip.read(MSR) & 1


@pytest.mark.parametrize(
    ("btr", "rate", "sample"),
    [
        (MEGABIT, 1_000_000, 11 / 14),
        (5 | 10 << 16 | 1 << 20, 500_000, 12 / 14),  # 42 / 6 = 7 MHz, 14 quanta
        (20 | 12 << 16 | 1 << 20, 125_000, 14 / 16),  # 42 / 21 = 2 MHz, 16 quanta
    ],
)
def test_bit_rate_and_sample_point(btr, rate, sample):
    chip = controller(btr=MEGABIT)
    chip.write(MCR, INRQ)
    chip.advance(100)
    chip.write(BTR, btr)
    assert chip.can1.bit_rate_hz == pytest.approx(rate)
    assert chip.can1.sample_point == pytest.approx(sample)


def test_bit_timing_is_closed_outside_initialization():
    chip = controller()
    chip.write(BTR, 0)
    assert chip.read(BTR) == MEGABIT
    assert "initialization" in reasons(chip)[0]


def test_a_wrong_rate_receives_nothing_and_counts_errors():
    chip = controller(btr=5 | 10 << 16 | 1 << 20)
    chip.can1.wire.send(Frame(1, b"x"))
    chip.advance(1000 * MICROSECOND)
    assert chip.can1.received == []
    assert chip.read(ESR) >> 24 > 0
    assert "500000 bit/s" in reasons(chip)[0]


# -- 32.7.1: mailboxes --


def test_a_frame_goes_out_and_takes_its_bits():
    chip = controller()
    begin = chip.now
    post(chip, 0, 0x123)
    until(chip, lambda: chip.read(TSR) & 1)
    start, end, sender, frame = chip.can1.wire.sent[0]
    assert (start, sender, frame) == (begin, "CAN1", Frame(0x123, b"\x01\x02", dlc=2))
    assert end - start == duration_bits(frame) * MICROSECOND
    assert chip.read(TSR) & 0xF == 3  # RQCP and TXOK
    chip.write(TSR, 1)
    assert chip.read(TSR) & 0xF == 0
    assert chip.complaints == []


def sent_order(chip):
    return [frame.identifier for _, _, _, frame in chip.can1.wire.sent]


def test_mailboxes_go_by_identifier_or_by_request():
    for mcr, order in ((0, [0x400, 0x100, 0x300]), (TXFP, [0x400, 0x300, 0x100])):
        chip = controller(mcr)
        for box, identifier in ((2, 0x400), (1, 0x300), (0, 0x100)):
            post(chip, box, identifier)  # the first is on the wire when the others come
        chip.advance(1000 * MICROSECOND)
        assert sent_order(chip) == order


def test_the_status_names_the_next_free_and_the_lowest_mailbox():
    chip = controller()
    assert chip.read(TSR) >> 24 == 0b0001_1100
    post(chip, 0, 0x100)
    assert chip.read(TSR) >> 24 == 0b0001_1001  # 1 and 2 empty, next free 1
    post(chip, 1, 0x300)
    post(chip, 2, 0x200)
    assert chip.read(TSR) >> 24 == 0b0100_0001  # none empty, mailbox 1 is of lowest priority


def test_another_nodes_lower_identifier_wins():
    chip = controller()
    chip.can1.wire.send(Frame(0x200, b"a"))
    chip.advance(MICROSECOND)
    post(chip, 0, 0x150)
    chip.can1.wire.send(Frame(0x100, b"b"))
    chip.advance(1000 * MICROSECOND)
    assert [(sender, frame.identifier) for _, _, sender, frame in chip.can1.wire.sent] == [
        ("wire", 0x200),
        ("wire", 0x100),
        ("CAN1", 0x150),
    ]
    assert chip.read(TSR) & 4  # ALST stays from the lost attempt


def test_a_pending_frame_is_aborted_and_one_on_the_wire_goes_on():
    chip = controller()
    post(chip, 0, 0x100)
    post(chip, 1, 0x200)
    chip.advance(10 * MICROSECOND)
    chip.write(TSR, 0x8080)
    assert chip.read(TSR) & 0x0F00 == 0x0100  # mailbox 1: RQCP without TXOK, at once
    assert not chip.read(TSR) & 1
    chip.advance(1000 * MICROSECOND)
    assert chip.read(TSR) & 3 == 3
    assert sent_order(chip) == [0x100]


def test_a_full_mailbox_cannot_be_written():
    chip = controller()
    post(chip, 0, 0x100)
    post(chip, 0, 0x101)
    assert "not empty" in reasons(chip)[0]
    assert chip.read(TI0R) >> 21 == 0x100


# -- 32.7.6: errors --


def test_without_acknowledge_a_lone_node_becomes_error_passive_and_not_bus_off():
    chip = controller()
    chip.can1.wire.others = False
    post(chip, 0, 0x100)
    chip.advance(20_000 * MICROSECOND)
    esr = chip.read(ESR)
    assert esr & 7 == 3  # warning and passive, not bus off
    assert esr >> 4 & 7 == 3  # acknowledge error
    assert esr >> 16 & 0xFF == 128
    chip.can1.wire.others = True
    chip.advance(1000 * MICROSECOND)
    assert chip.read(TSR) & 3 == 3


def test_no_retransmission_with_nart():
    chip = controller(NART)
    chip.can1.wire.disturb = 1
    post(chip, 0, 0x100)
    chip.advance(1000 * MICROSECOND)
    assert chip.read(TSR) & 0xF == 9  # RQCP and TERR
    assert sent_order(chip) == []


@pytest.mark.parametrize("abom", [0, ABOM])
def test_bus_off_after_32_errors_and_the_way_back(abom):
    chip = controller(abom)
    chip.can1.wire.disturb = 32
    post(chip, 0, 0x100)
    until(chip, lambda: chip.read(ESR) & 4)
    off = chip.now
    if not abom:
        chip.advance(5000 * MICROSECOND)
        assert chip.read(ESR) & 4
        chip.write(MCR, INRQ)
        chip.advance(100)
        chip.write(MCR, 0)
    until(chip, lambda: not chip.read(ESR) & 4)
    if abom:
        assert chip.now - off == pytest.approx(128 * 11 * MICROSECOND, rel=0.02)
    chip.advance(1000 * MICROSECOND)
    assert sent_order(chip) == [0x100]
    assert chip.read(ESR) >> 16 & 0xFF == 0


def test_silent_mode_neither_sends_nor_acknowledges():
    chip = controller(btr=MEGABIT | SILENT)
    post(chip, 0, 0x100)
    chip.advance(1000 * MICROSECOND)
    assert chip.can1.wire.sent == []
    chip.can1.wire.send(Frame(5, b"q"))
    chip.advance(1000 * MICROSECOND)
    assert chip.read(RF0R) & 3 == 1
    assert not chip.can1.acknowledges


def test_loop_back_hears_itself_without_anyone_else():
    chip = controller(btr=MEGABIT | LOOP_BACK)
    chip.can1.wire.others = False
    post(chip, 0, 0x100)
    chip.advance(1000 * MICROSECOND)
    assert chip.read(RF0R) & 3 == 1
    assert chip.read(RI0R) >> 21 == 0x100


def test_a_node_does_not_hear_itself_otherwise():
    chip = controller()
    post(chip, 0, 0x100)
    chip.advance(1000 * MICROSECOND)
    assert chip.read(RF0R) & 3 == 0


# -- 32.7.3: FIFOs; 32.7.4: filters --


def receive(chip, *frames):
    for frame in frames:
        chip.can1.wire.send(frame)
        chip.advance(300 * MICROSECOND)


def test_a_frame_is_read_from_the_output_mailbox_and_released():
    chip = controller()
    receive(chip, Frame(0x7FF, bytes(range(1, 9))), Frame(0x1ABCDEF, b"z", extended=True))
    assert chip.read(RI0R) == 0x7FF << 21
    assert chip.read(RI0R + 4) & 15 == 8
    assert chip.read(RI0R + 8) == 0x04030201
    assert chip.read(RI0R + 12) == 0x08070605
    chip.write(RF0R, 0x20)
    assert chip.read(RI0R) == 0x1ABCDEF << 3 | 4
    chip.write(RF0R, 0x20)
    assert chip.read(RF0R) & 3 == 0
    assert chip.complaints == []


@pytest.mark.parametrize(("mcr", "kept"), [(0, [1, 2, 5]), (RFLM, [1, 2, 3])])
def test_a_full_fifo_overwrites_its_last_or_locks(mcr, kept):
    chip = controller(mcr)
    receive(chip, *(Frame(n) for n in range(1, 6)))
    assert chip.read(RF0R) == 3 | 8 | 16  # three, full, overrun
    chip.write(RF0R, 8 | 16)
    seen = []
    while chip.read(RF0R) & 3:
        seen.append(chip.read(RI0R) >> 21)
        chip.write(RF0R, 0x20)
    assert seen == kept


def taken(chip, *frames):
    """Return (FIFO, filter match index) for each frame, None for those left out."""
    result = []
    for frame in frames:
        receive(chip, frame)
        found = None
        for fifo, (flags, box) in enumerate(((RF0R, RI0R), (RF1R, RI1R))):
            if chip.read(flags) & 3:
                found = fifo, chip.read(box + 4) >> 8 & 0xFF
                chip.write(flags, 0x20)
        result.append(found)
    return result


def standard(identifier):
    return identifier << 21


def half(identifier, remote=0, extended=0):
    return identifier << 5 | remote << 4 | extended << 3


def test_mask_of_32_bits():
    chip = controller()
    filters(chip, [(True, False, 0, standard(0x120), standard(0x7F0) | 4)])  # 0x120 to 0x12F, IDE must be 0
    assert taken(chip, Frame(0x12F), Frame(0x130), Frame(0x120 << 18, extended=True)) == [(0, 0), None, None]


def test_list_of_32_bits():
    chip = controller()
    filters(chip, [(True, True, 1, standard(0x111), 0x1ABCDEF << 3 | 4)])
    frames = Frame(0x111), Frame(0x1ABCDEF, extended=True), Frame(0x111, remote=True), Frame(0x112)
    assert taken(chip, *frames) == [(1, 0), (1, 1), None, None]


def test_masks_and_lists_of_16_bits():
    chip = controller()
    mask = half(0x700, 1, 1)  # the three upper bits, data frames, standard
    filters(
        chip,
        [
            (False, False, 0, mask << 16 | half(0x200), mask << 16 | half(0x300)),
            (False, True, 0, half(0x402) << 16 | half(0x401), half(0x404) << 16 | half(0x403)),
        ],
    )
    frames = Frame(0x2FF), Frame(0x300), Frame(0x401), Frame(0x402), Frame(0x403), Frame(0x404), Frame(0x405)
    assert taken(chip, *frames) == [(0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (0, 5), None]


def test_wide_filters_and_lists_go_first():
    chip = controller()
    everything = (False, False, 0, 0, 0)
    filters(chip, [everything, (True, False, 1, 0, 0), (True, True, 0, standard(5), standard(6))])
    # FIFO 0 holds filters 0 and 1 (bank 0), 2 and 3 (bank 2); FIFO 1 filter 0 (bank 1).
    assert taken(chip, Frame(5), Frame(6), Frame(7)) == [(0, 2), (0, 3), (1, 0)]


def test_nothing_is_received_while_the_filters_are_being_set():
    chip = controller()
    chip.write(FMR, chip.read(FMR) | 1)
    assert taken(chip, Frame(5)) == [None]


def test_filters_are_closed_while_in_use():
    chip = controller()
    chip.write(F0R1, 1)
    chip.write(FM1R, 1)
    assert "FINIT is 0" in reasons(chip)[0]
    assert chip.read(F0R1) == 0


# -- 32.8: interrupts --


def test_interrupts_follow_their_flags():
    chip = controller()
    chip.write(0xE000_E100, 1 << 19 | 1 << 20)
    chip.write(IER, 1 | 2)
    receive(chip, Frame(1))
    assert chip.pending_interrupts() == [36]
    chip.nvic.enter(36)
    chip.write(RF0R, 0x20)
    chip.nvic.leave()
    assert chip.pending_interrupts() == []
    post(chip, 0, 2)
    chip.advance(300 * MICROSECOND)
    assert chip.pending_interrupts() == [35]


def test_status_words_may_be_written_back_as_they_were_read():
    chip = controller()
    post(chip, 0, 0x100)
    receive(chip, Frame(1))
    for address in (TSR, MSR, RF0R, ESR):
        chip.write(address, chip.read(address))
    assert chip.complaints == []


def test_a_master_reset_puts_the_chip_to_sleep():
    chip = controller()
    chip.write(MCR, 1 << 15)
    assert chip.read(MSR) & 3 == 2
    assert chip.read(BTR) == 0x0123_0000
