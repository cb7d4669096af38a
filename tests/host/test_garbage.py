"""Garbage: the search for it is put off while the program starts, and all is as before at the end."""

import gc

import pytest

from masonry_fem.host.memory import put_off, taken_up


def test_the_search_begins_after_what_stays():
    with put_off():
        assert not gc.isenabled()
        taken_up()
        assert gc.isenabled()
        assert gc.get_freeze_count() > 0
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0


def test_an_error_leaves_the_search_as_it_was():
    with pytest.raises(ValueError, match="wrong"), put_off():
        raise ValueError("wrong")
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0


def test_whoever_searches_by_itself_is_left_alone():
    gc.disable()
    try:
        with put_off():
            taken_up()
            assert not gc.isenabled()
        assert not gc.isenabled()
    finally:
        gc.enable()
