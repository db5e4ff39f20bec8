"""Rows that the loop writes, taken over chunk by chunk."""

import numpy as np

from runtime.core.function_table_slots import EVENT_ROWS, OUT_ROWS, SAMPLE_TIMES
from runtime.integrate.recording_buffers import Recording
from runtime.integrate.wiring import wire
from tests.runtime.integrate.systems import relay

FLOOR = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def recording(t_eval=None, interval=None):
    system, p = relay(FLOOR)
    wiring = wire(system, "dopri5", p, 4)
    return Recording(wiring, 1, 1, t_eval, interval), wiring.arrays, wiring.table


def write_samples(arrays, record, first, count):
    for i in range(count):
        arrays["out_times"][i] = first + i
        arrays["out_states"][i] = first + i, -1.0
    record["samples"] = count


def test_samples_of_two_chunks_are_joined():
    taken, arrays, table = recording()
    taken.make_room(5)
    assert table[OUT_ROWS] == 5
    for first, count in ((0, 5), (5, 2)):
        write_samples(arrays, taken.record, first, count)
        taken.flush()
        assert taken.record["samples"] == 0
    t, y, modes = taken.samples()
    assert t.tolist() == y[:, 0].tolist() == [0, 1, 2, 3, 4, 5, 6]
    assert modes.shape == (7, 1)


def test_samples_at_given_instants_stay_in_place():
    taken, arrays, table = recording(np.array([0.5, 1.0, 2.0]))
    assert table[SAMPLE_TIMES] == table[OUT_ROWS] == 3
    write_samples(arrays, taken.record, 0, 2)
    taken.make_room(100)
    taken.flush()
    assert taken.record["samples"] == 2
    assert taken.samples()[0].tolist() == [0.0, 1.0]


def test_a_quadrature_has_room_for_each_interval():
    taken, _, table = recording(np.array([0.5, 1.0]), interval=6)
    taken.make_room(10)
    assert table[OUT_ROWS] == 6 * (10 + 2)


def test_events_of_the_loop_and_of_the_start():
    taken, arrays, table = recording()
    taken.add_events(0.0, np.array([0]), [2], np.array([0.1, 0.2]))
    assert table[EVENT_ROWS] >= 64
    arrays["event_times"][0] = 1.5
    arrays["event_kinds"][0] = 0, -1
    arrays["event_states"][0] = 0.3, 0.4
    taken.record["logged_events"] = 1
    taken.flush()
    assert taken.record["logged_events"] == 0
    events = taken.events()
    assert events.t.tolist() == [0.0, 1.5]
    assert events.direction.tolist() == [2, -1]
    assert (events.q[:, 0].tolist(), events.v[:, 0].tolist()) == ([0.1, 0.3], [0.2, 0.4])


def test_partitions_and_none_of_anything():
    taken, arrays, _ = recording()
    assert taken.events().q.shape == (0, 1)
    assert taken.partitions().independent.shape == (0, 1)
    arrays["log_times"][0], arrays["log_sets"][0] = 2.5, 1
    taken.record["logged_repartitions"] = 1
    taken.flush()
    taken.flush()
    assert taken.partitions().t.tolist() == [2.5]
    assert taken.partitions().independent.tolist() == [[True]]
