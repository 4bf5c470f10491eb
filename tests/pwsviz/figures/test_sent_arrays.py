"""Columns reach the browser as they are, in few messages."""

import numpy as np
import pytest
from bokeh.core.serialization import Deserializer, Serializer
from bokeh.models import ColumnDataSource

from pwsviz.figures.sent_arrays import FEW, MOST, sent
from pwsviz.figures.style import assign

LINE = np.random.default_rng(0).normal(size=FEW + 1)
LINE[3] = np.nan


@pytest.mark.parametrize("array", [LINE, LINE[::-2], np.column_stack([LINE, LINE])[:, 1]])
def test_an_array_is_sent_within_the_message_bit_by_bit(array):
    written = Serializer().serialize(sent([array])[0])
    assert not written.buffers
    assert np.array_equal(Deserializer().decode(written.content), array, equal_nan=True)


def test_a_large_array_is_sent_by_itself():
    assert len(Serializer().serialize(sent(np.zeros(MOST + 1))).buffers) == 1


def test_lines_and_outlines_of_a_source_are_sent_within_the_message():
    source = ColumnDataSource({"xs": [], "rings": [], "t": []})
    rings, t = [[[LINE, LINE[:9]]], [[LINE]]], LINE[:2]
    assign(source, xs=[LINE, LINE[:7]], rings=rings, t=t)
    assert not Serializer().serialize(source.data).buffers
    before = source.data
    assign(source, xs=[LINE.copy(), LINE[:7]], rings=[[[LINE, LINE[:9].copy()]], [[LINE]]], t=t.copy())
    assert source.data is before
    assign(source, xs=[LINE, LINE[:6]], rings=rings, t=t)
    assert source.data is not before


def test_lines_of_several_lengths_may_all_go():
    source = ColumnDataSource({"xs": [LINE, LINE[:7]]})
    assign(source, xs=[])
    assert source.data["xs"] == []
