"""The board's number against the published CRC-30 and against long division; answers to all do not meet twice."""

from hypothesis import given
from hypothesis import strategies as st

from shared.wire.identity import DISCOVER_SLOTS, board_id, discover_delay_ms

POLYNOMIAL = (1 << 30) | 0x2030B9C7


def long_division(data):
    """CRC-30 as the remainder of one big number: preset all ones, result inverted."""
    bits = 8 * len(data)
    number = (int.from_bytes(data, "big") << 30) ^ (((1 << 30) - 1) << bits)
    for place in range(bits + 29, 29, -1):
        if number >> place & 1:
            number ^= POLYNOMIAL << (place - 30)
    return number ^ ((1 << 30) - 1)


def test_check_value_of_crc30_cdma():
    assert board_id(b"123456789") == 0x04C34ABF


@given(st.binary(min_size=12, max_size=12))
def test_board_id_equals_long_division(unique_id):
    assert board_id(unique_id) == long_division(unique_id)
    assert 0 <= board_id(unique_id) < 1 << 30


@given(st.integers(0, (1 << 30) - 1), st.integers(0, 255))
def test_delay_is_a_slot(board, sequence):
    assert 0 <= discover_delay_ms(board, sequence) < DISCOVER_SLOTS


def test_boards_of_one_lot_part_after_a_few_requests():
    """Unique ids of one wafer differ in few bits: any two must get different slots in most requests."""
    boards = [board_id(bytes([lot, 0, number, 0, 0x47, 0x51, 0x33, 0x30, 0x37, 0x31, 0x34, 0x39]))
              for lot in range(8) for number in range(24)]  # fmt: skip
    assert len(set(boards)) == len(boards)
    for i, one in enumerate(boards):
        for other in boards[:i]:
            apart = sum(discover_delay_ms(one, s) != discover_delay_ms(other, s) for s in range(1, 9))
            assert apart >= 4
