"""CAN1: RM0090 section 32; frame lengths by ISO 11898-1."""

import pytest

from host.sim.chip.can_wire import Frame, duration_bits, frame_on_wire, stuffed

from .board import CAN1, clocked, reasons, set_pin

MCR, MSR, TSR, RF0R, RF1R, _, ESR, BTR = (CAN1 + 4 * n for n in range(8))
TI0R, RI0R, RI1R = CAN1 + 0x180, CAN1 + 0x1B0, CAN1 + 0x1C0
FMR, FM1R, FS1R, FFA1R, FA1R, F0R1 = (CAN1 + n for n in (0x200, 0x204, 0x20C, 0x214, 0x21C, 0x240))
INRQ, ABOM = 1, 64
# 42 MHz / 3 / (1 + 10 + 3) = 1 Mbit/s, sampled at 11 / 14
MEGABIT = 2 | 9 << 16 | 2 << 20 | 0 << 24
MICROSECOND = 168


def until(chip, condition, limit_us=20_000):
    begin = chip.now
    while not condition():
        assert chip.now - begin < limit_us * MICROSECOND
        chip.advance(10)


def controller(mcr=0, btr=MEGABIT):
    """Return a chip with CAN1 on the bus; filter 0 takes everything unless told otherwise."""
    chip = clocked()
    set_pin(chip, "PB8", 2, 9)
    set_pin(chip, "PB9", 2, 9)
    chip.write(MCR, INRQ | mcr)
    until(chip, lambda: chip.read(MSR) & 1)
    chip.write(BTR, btr)
    filters(chip, [(0, 0, 0)])
    chip.write(MCR, mcr)
    until(chip, lambda: not chip.read(MSR) & 1)
    return chip


def filters(chip, banks):
    """Set banks of (FIFO, first register, second register), each register a mask above an identifier."""
    chip.write(FMR, chip.read(FMR) | 1)
    chip.write(FA1R, 0)
    chip.write(FFA1R, sum(bank[0] << n for n, bank in enumerate(banks)))
    for n, bank in enumerate(banks):
        chip.write(F0R1 + 8 * n, bank[1])
        chip.write(F0R1 + 8 * n + 4, bank[2])
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
    assert len(frame_on_wire(Frame(0x555, b"\x55"))) >= 34 + 8


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
    until(chip, lambda: chip.can1.wire.sent)
    start, end, sender, frame = chip.can1.wire.sent[0]
    assert (start, sender, frame) == (begin, "CAN1", Frame(0x123, b"\x01\x02"))
    assert end - start == duration_bits(frame) * MICROSECOND
    assert chip.read(TSR) == 7 << 26  # all three empty
    assert chip.complaints == []


def sent_order(chip):
    return [frame.identifier for _, _, _, frame in chip.can1.wire.sent]


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


def test_a_full_mailbox_cannot_be_written():
    chip = controller()
    post(chip, 0, 0x100)
    post(chip, 0, 0x101)
    assert "not empty" in reasons(chip)[0]
    assert chip.read(TI0R) >> 21 == 0x100


# -- 32.7.6: errors --


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


def taken(chip, *frames):
    """Return the FIFO for each frame, None for those left out."""
    result = []
    for frame in frames:
        receive(chip, frame)
        found = None
        for fifo, flags in enumerate((RF0R, RF1R)):
            if chip.read(flags) & 3:
                found = fifo
                chip.write(flags, 0x20)
        result.append(found)
    return result


def test_masks_of_16_bits():
    chip = controller()
    mask = 0x700 << 5 | 1 << 4 | 1 << 3  # the three upper bits, data frames, standard
    filters(chip, [(0, mask << 16 | 0x200 << 5, mask << 16 | 0x300 << 5), (1, *[mask << 16 | 0x400 << 5] * 2)])
    frames = Frame(0x2FF), Frame(0x300), Frame(0x4FF), Frame(0x500), Frame(0x200, remote=True)
    assert taken(chip, *frames, Frame(0x200 << 18, extended=True)) == [0, 0, 1, None, None, None]


def test_nothing_is_received_while_the_filters_are_being_set():
    chip = controller()
    chip.write(FMR, chip.read(FMR) | 1)
    assert taken(chip, Frame(5)) == [None]


def test_filters_are_closed_while_in_use():
    chip = controller()
    chip.write(F0R1, 1)
    chip.write(FFA1R, 1)
    assert all("FINIT is 0" in reason for reason in reasons(chip))
    assert chip.read(F0R1) == 0


def test_a_full_fifo_overwrites_its_last():
    chip = controller()
    receive(chip, *(Frame(n) for n in range(1, 6)))
    assert chip.read(RF0R) == 3 | 8 | 16  # three, full, overrun
    chip.write(RF0R, 8 | 16)
    seen = []
    while chip.read(RF0R) & 3:
        seen.append(chip.read(RI0R) >> 21)
        chip.write(RF0R, 0x20)
    assert seen == [1, 2, 5]


def test_bus_off_after_32_errors_and_the_way_back():
    chip = controller(ABOM)
    chip.can1.wire.disturb = 32
    post(chip, 0, 0x100)
    until(chip, lambda: chip.read(ESR) & 4)
    off = chip.now
    until(chip, lambda: not chip.read(ESR) & 4)
    assert chip.now - off == pytest.approx(128 * 11 * MICROSECOND, rel=0.02)
    chip.advance(1000 * MICROSECOND)
    assert sent_order(chip) == [0x100]
    assert chip.read(ESR) >> 16 & 0xFF == 0


@pytest.mark.parametrize(
    ("address", "word"), [(FS1R, 1), (FM1R, 1), (MCR, 4), (TI0R, 1 << 2)], ids=["32 bits", "lists", "TXFP", "extended"]
)
def test_what_is_not_modelled_is_told(address, word):
    chip = controller()
    chip.write(FMR, chip.read(FMR) | 1)
    chip.write(address, word)
    assert "not modelled" in reasons(chip)[0]
