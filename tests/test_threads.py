"""Work in threads: outcomes in order, from any depth, with errors that do not depend on who was first."""

import threading
import time

import pytest

from indoor_bim.threads import in_threads


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_outcomes_are_in_the_order_of_the_items(threads):
    def late_first(item):
        time.sleep(0.01 if item == 0 else 0)
        return item * item

    assert in_threads(late_first, range(20), threads=threads) == [item * item for item in range(20)]


def test_work_may_have_work_in_threads_of_its_own():
    def nested(item):
        return sum(in_threads(lambda other: item * other, range(4), threads=3))

    assert in_threads(nested, range(6), threads=4) == [6 * item for item in range(6)]


def test_the_caller_does_all_of_it_while_its_helpers_are_busy():
    held = threading.Event()

    def busy():
        in_threads(lambda _: held.wait(10), range(8), threads=8)

    others = [threading.Thread(target=busy) for _ in range(2)]
    for other in others:
        other.start()
    assert in_threads(abs, [-1, -2], threads=2) == [1, 2]
    held.set()
    for other in others:
        other.join()


def test_the_first_error_in_the_order_of_the_items_is_raised():
    done = []

    def fails_at_odd(item):
        time.sleep(0.01 if item == 1 else 0)
        if item % 2:
            raise ValueError(item)
        done.append(item)

    with pytest.raises(ValueError, match=r"^1$"):
        in_threads(fails_at_odd, range(6), threads=3)
    assert sorted(done) == [0, 2, 4]
