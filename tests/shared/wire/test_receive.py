"""The joint's end of the bus: addresses, filters, set-points latched on SYNC, losses, sessions, twins."""

from array import array

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from host.protocol import frames
from shared.record import pack, unpack
from shared.wire import framing, names, receive
from shared.wire import receive as r

ALL = frames.kinds()


def fresh(node=1):
    link = r.Link()
    unpack(link, [7] * len(pack(link)))
    r.link_reset(link, node)
    return link


def take(link, identifier, values):
    data, _ = frames.encode(identifier, values)
    return take_bytes(link, identifier, data)


def take_bytes(link, identifier, data):
    frame = frames.new_frame()
    frame.data[: len(data)] = data
    return r.accept_frame(link, identifier, frame.words, len(data))


def sync(link, counter, session=9):
    return take(link, names.SYNC_ID, [counter, session])


def test_every_identifier_has_one_address():
    for identifier, kind in ALL.items():
        block = framing.frame_block(identifier)
        if kind.message.instance_of == "group":
            assert block == names.SETPOINT_POSITION_ID
            assert framing.setpoint_group(identifier) == kind.instance
            assert framing.setpoint_kind(identifier) == kind.message.identifier & 7
        else:
            assert block == kind.message.identifier
            assert framing.frame_node(identifier) == kind.instance
    assert framing.frame_block(-1) == framing.frame_block(0x800) == -1
    assert framing.frame_node(names.REPLY_ID + 13) == -1
    assert framing.setpoint_group(0x118) == -1
    assert [framing.node_group(n) for n in (0, 1, 4, 5, 12, 13)] == [-1, 0, 0, 1, 2, -1]
    assert [framing.node_slot(n) for n in range(1, 13)] == [0, 1, 2, 3] * 3


@pytest.mark.parametrize("node", range(13))
def test_filters_pass_exactly_what_the_joint_takes(node):
    pairs = array("H", [0] * (2 * framing.FILTERS))
    count = framing.joint_filters(pairs, node)
    passed = {i for i in range(0x800) for k in range(count) if i & pairs[2 * k + 1] == pairs[2 * k] & pairs[2 * k + 1]}
    link, taken = fresh(node), set()
    for identifier in range(0x800):
        length = ALL[identifier].message.length if identifier in ALL else 8
        if take_bytes(link, identifier, bytes(length)) != r.FRAME_NOT_MINE:
            taken.add(identifier)
    assert passed == taken


def test_set_points_wait_for_sync_and_change_together():
    link = fresh(node=6)  # group 1, slot 1
    assert take(link, 0x108, [10, 20, 30, 40]) == r.FRAME_SETPOINT
    assert link.mode == 0
    assert sync(link, 0) == r.FRAME_SYNC_SETPOINT
    assert (link.mode, link.latched[r.KIND_POSITION]) == (names.MODE_POSITION, 20)
    assert take(link, 0x100, [1, 2, 3, 4]) == r.FRAME_NOT_MINE
    assert take(link, 0x108, [0, names.NO_CHANGE, 0, 0]) == r.FRAME_NOT_MINE
    assert sync(link, 1) == r.FRAME_SYNC
    assert link.latched[r.KIND_POSITION] == 20


def test_feed_forward_lasts_one_set_point_and_gains_stay():
    link = fresh()
    take(link, names.SETPOINT_IMPEDANCE_ID, [100, 0, 0, 0])
    take(link, names.FEEDFORWARD_CURRENT_ID, [-50, 0, 0, 0])
    take(link, names.IMPEDANCE_STIFFNESS_ID, [600, 0, 0, 0])
    assert sync(link, 0) == r.FRAME_SYNC_SETPOINT
    assert link.mode == names.MODE_IMPEDANCE
    assert (link.latched[r.KIND_CURRENT_FEEDFORWARD], link.latched[r.KIND_STIFFNESS]) == (-50, 600)
    assert sync(link, 1) == r.FRAME_SYNC
    assert link.latched[r.KIND_CURRENT_FEEDFORWARD] == -50
    take(link, names.SETPOINT_IMPEDANCE_ID, [101, 0, 0, 0])
    assert sync(link, 2) == r.FRAME_SYNC_SETPOINT
    assert (link.latched[r.KIND_CURRENT_FEEDFORWARD], link.latched[r.KIND_STIFFNESS]) == (0, 600)


def test_feed_forward_and_gains_alone_are_no_set_point():
    link = fresh()
    for base in (names.FEEDFORWARD_VELOCITY_ID, names.FEEDFORWARD_CURRENT_ID, names.IMPEDANCE_DAMPING_ID):
        assert take(link, base, [5, 5, 5, 5]) == r.FRAME_SETPOINT
        assert sync(link, 0) == r.FRAME_SYNC
    assert link.mode == 0


def test_last_mode_of_a_cycle_wins():
    link = fresh()
    for kind, mode in ((0, names.MODE_POSITION), (2, names.MODE_CURRENT), (1, names.MODE_VELOCITY)):
        take(link, 0x100 + kind, [3, 0, 0, 0])
        take(link, 0x100 + (kind + 1) % 3, [names.NO_CHANGE, 0, 0, 0])
        assert sync(link, 0) == r.FRAME_SYNC_SETPOINT
        assert link.mode == mode


def test_lost_syncs_are_counted_over_the_wrap_and_stay_at_the_top():
    link = fresh()
    for counter in (254, 255, 0, 1, 5):
        sync(link, counter)
    assert link.lost_syncs == 3
    link.lost_syncs = (1 << 30) - 2
    sync(link, 10)
    assert link.lost_syncs == (1 << 30) - 1


def test_another_session_latches_nothing_and_takes_nothing_away():
    link = fresh()
    r.start_session(link, 9)
    take(link, 0x100, [10, 0, 0, 0])
    assert sync(link, 3, session=9) == r.FRAME_SYNC_SETPOINT
    take(link, 0x100, [99, 0, 0, 0])
    assert sync(link, 77, session=8) == r.FRAME_OTHER_SESSION
    assert link.latched[0] == 10
    for counter in range(100):
        assert sync(link, counter, session=8) == r.FRAME_OTHER_SESSION
    assert sync(link, 4, session=9) == r.FRAME_SYNC_SETPOINT
    assert (link.latched[0], link.lost_syncs) == (99, 0)
    r.end_session(link)
    assert (link.session, link.mode, link.latched[0]) == (0, 0, 0)
    assert sync(link, 5, session=8) == r.FRAME_SYNC


def test_e_stop_counts_whatever_it_carries():
    for data in (b"", b"\x00", bytes(8)):
        assert take_bytes(fresh(), names.E_STOP_ID, data) == r.FRAME_E_STOP
    assert take_bytes(fresh(), 0x001, b"") == r.FRAME_NOT_MINE


def test_short_and_forbidden_frames_are_dropped_and_counted():
    link = fresh()
    for identifier, data in ((0x100, bytes(7)), (names.SYNC_ID, b"\x00"), (names.SERVICE_REQUEST_ID + 1, bytes(4))):
        assert take_bytes(link, identifier, data) == r.FRAME_BAD
    assert take_bytes(link, names.IMPEDANCE_STIFFNESS_ID, b"\xff\xff" + bytes(6)) == r.FRAME_BAD
    assert link.bad_frames == 4
    assert link.pending_set == 0


def test_requests_and_twins():
    link = fresh(node=3)
    request = [names.COMMAND_DISCOVER, 1, 9, 0, 0]
    assert take(link, names.SERVICE_REQUEST_ID, request) == r.FRAME_REQUEST
    assert take(link, names.SERVICE_REQUEST_ID + 3, request) == r.FRAME_REQUEST
    assert take(link, names.SERVICE_REQUEST_ID + 4, request) == r.FRAME_NOT_MINE
    assert take_bytes(link, names.HEARTBEAT_ID + 3, bytes(8)) == r.FRAME_TWIN
    assert take_bytes(link, names.REPLY_ID + 3, bytes(6)) == r.FRAME_TWIN
    assert take_bytes(link, names.REPLY_ID + 4, bytes(6)) == r.FRAME_NOT_MINE
    assert take_bytes(fresh(node=0), names.HEARTBEAT_ID, bytes(8)) == r.FRAME_NOT_MINE


FRAMES = st.tuples(
    st.one_of(st.sampled_from(sorted(ALL)), st.integers(0, 0x7FF)), st.binary(max_size=8)
)


@settings(max_examples=200)
@given(st.integers(0, 12), st.integers(0, 3), st.lists(FRAMES, max_size=40))
def test_random_frames_never_make_a_set_point_up(node, session, received):
    link, wanted = fresh(node), {}
    if session:
        r.start_session(link, session)
    for identifier, data in received:
        before = list(link.latched)
        found = take_bytes(link, identifier, data)
        if found == r.FRAME_SETPOINT:
            slot = 2 * framing.node_slot(node)
            wanted[identifier & 7] = int.from_bytes(data[slot : slot + 2], "little", signed=True)
        if found in (r.FRAME_SYNC, r.FRAME_SYNC_SETPOINT):
            for kind in range(framing.SETPOINT_KINDS):
                allowed = {wanted[kind]} if kind in wanted else {before[kind], 0}
                assert link.latched[kind] in allowed
        else:
            assert list(link.latched) == before
        if found in (r.FRAME_SYNC, r.FRAME_SYNC_SETPOINT, r.FRAME_OTHER_SESSION):
            assert (found == r.FRAME_SYNC_SETPOINT) == (min(wanted, default=9) < 4 and found != r.FRAME_OTHER_SESSION)
            wanted.clear()
        assert all(-(1 << 30) <= value < 1 << 30 for value in pack(link))


def test_kinds_of_set_points_stand_as_in_the_dbc():
    order = ["SETPOINT_POSITION", "SETPOINT_VELOCITY", "SETPOINT_CURRENT", "SETPOINT_IMPEDANCE",
             "FEEDFORWARD_VELOCITY", "FEEDFORWARD_CURRENT", "IMPEDANCE_STIFFNESS", "IMPEDANCE_DAMPING"]  # fmt: skip
    kinds = ["POSITION", "VELOCITY", "CURRENT", "IMPEDANCE", "VELOCITY_FEEDFORWARD", "CURRENT_FEEDFORWARD",
             "STIFFNESS", "DAMPING"]  # fmt: skip
    for identifier, kind in zip(order, kinds, strict=True):
        assert getattr(names, f"{identifier}_ID") == names.SETPOINT_POSITION_ID + getattr(receive, f"KIND_{kind}")
    for kind in kinds[:4]:
        assert getattr(names, f"MODE_{kind}") == getattr(receive, f"KIND_{kind}") + 1
