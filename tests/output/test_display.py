"""Display: on a terminal, what takes long is shown with the time that is left; elsewhere nothing is."""

import io
import re
import time

import pytest
from rich.console import Console

from masonry_fem.host.phases import counted, heard, listener, phase
from masonry_fem.output.display import Display, shown, span
from masonry_fem.output.search_table import halvings, watched


def displayed(work, *, terminal=True, delay=0.05, width=120):
    """What a terminal gets while ``work`` runs."""
    out = io.StringIO()
    with Display(Console(file=out, force_terminal=terminal, width=width), delay) as display, heard(display):
        work()
    return out.getvalue()


def slow():
    with phase("meshes", 4) as at:
        at(1, "stone [1]")
        time.sleep(0.4)


def test_what_takes_long_is_shown_with_the_time_left():
    text = displayed(slow)
    assert "meshes" in text
    assert "stone [1]" in text
    assert "left" in text


def test_a_long_note_leaves_the_time_in_one_line():
    def search():
        with phase("trials", 4) as at:
            at(1, "stands at 41.7625, falls at 38.55, the next is 40.1562 of 60")
            time.sleep(0.4)

    text = displayed(search, width=60)
    assert re.search(r"about \d+ s left", text)
    assert "of 60" in text, "all of the note is there"


def test_what_is_short_is_not_shown():
    assert displayed(slow, delay=5.0) == ""


def test_pipes_get_nothing():
    assert displayed(slow, terminal=False) == ""


def test_only_the_phases_that_take_long_have_a_line():
    def work():
        with phase("steps"):
            for _ in range(20):
                with phase("contact problem"):
                    time.sleep(0.02)

    text = displayed(work, delay=0.2)
    assert "steps" in text
    assert "contact problem" not in text


def test_lines_go_with_the_last_phase():
    """What is printed next does not get into them."""
    out = io.StringIO()
    with Display(Console(file=out, force_terminal=True, width=80), 0.05) as display, heard(display):
        slow()
        size = len(out.getvalue())
        time.sleep(0.3)
        assert len(out.getvalue()) == size


def test_nobody_listens_by_default(capsys):
    assert listener() is None
    slow()
    assert capsys.readouterr() == ("", "")


def test_one_display_at_a_time():
    with shown(True):
        first = listener()
        with shown(True):
            assert listener() is first
    with shown(False):
        assert listener() is None


def test_an_error_ends_a_phase():
    with pytest.raises(ValueError, match="wrong"), Display() as display, heard(display), phase("meshes"):
        raise ValueError("wrong")
    assert not display._open


@pytest.mark.parametrize(
    ("seconds", "words"), [(8.2, "8 s"), (59.6, "1 min 0 s"), (200, "3 min 20 s"), (7500, "2 h 5 min")]
)
def test_times_are_words(seconds, words):
    assert span(seconds) == words


@pytest.mark.parametrize(
    ("stands", "falls", "trials"),
    [(None, 1.0, 1), (1.0, 2.0, 6), (1.0, 1.01, 0), (2.0, 1.0, 6), (1.0, 1.0, 0)],
)
def test_a_search_knows_how_many_halvings_are_left(stands, falls, trials):
    assert halvings(stands, falls, 0.01) == trials


def test_a_search_tells_its_trials():
    text = []

    class Listener:
        def begin(self, what, total):
            return lambda done, note="", total=None: text.append((done, note, total))

        def end(self, at):
            text.append("end")

    with heard(Listener()), watched(0.01) as say:
        say(1.5, "stands", 1.5, 2.0)
    assert text[1][0] == 1
    assert text[1][2] == 1 + halvings(1.5, 2.0, 0.01)
    assert "stands at 1.5, falls at 2" in text[1][1]
    assert text[-1] == "end"


def test_items_are_counted():
    told = []

    class Listener:
        def begin(self, what, total):
            told.append((what, total))
            return lambda done, note="", total=None: told.append(done)

        def end(self, at):
            told.append("end")

    with heard(Listener()):
        assert list(counted("factors", ["a", "b"])) == ["a", "b"]
    assert told[:4] == [("factors", 2), 1, 2, "end"]
    with heard(Listener()):
        assert list(counted("frames", iter("abc"), 3)) == ["a", "b", "c"]
    assert told[4:] == [("frames", 3), 1, 2, 3, "end"]
    assert list(counted("factors", ["a"])) == ["a"]
