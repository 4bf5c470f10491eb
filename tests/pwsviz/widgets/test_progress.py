"""A long computation says how far it is."""

from pwsviz.widgets.progress import Progress


def test_from_the_beginning_to_the_end():
    progress = Progress(lambda: None, lambda: None)
    assert not progress.busy
    progress.begin()
    assert progress.busy
    progress.advance(3, 12)
    assert progress.busy
    assert 'value="0.25"' in progress._bar.object
    assert progress._words.object == "25 %"
    progress.advance(1234, 5000)
    assert progress._words.object == "24 %"
    progress.end()
    assert not progress.busy


def test_a_result_that_stays_in_sight_meanwhile_is_called_the_former_one():
    progress = Progress(lambda: None, lambda: None)
    progress.begin()
    assert progress._words.object == "preparing …"
    progress.begin(former=True)
    assert progress._words.object == "preparing … (the previous result is shown below)"


def test_what_was_cancelled_can_be_begun_again():
    told = []
    progress = Progress(lambda: told.append("cancel"), lambda: told.append("again"))
    progress.begin()
    progress._cancel.clicks += 1
    progress.stop()
    assert not progress.busy
    assert progress._again.visible
    progress._again.clicks += 1
    assert told == ["cancel", "again"]
