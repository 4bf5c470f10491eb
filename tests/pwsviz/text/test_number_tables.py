"""Tables of figures as HTML."""

from pwsviz.text.tables import Numbers, table_markup


def test_cells_are_never_markup_and_headers_are_headers():
    table = Numbers(("integrator", "τ"), (("<b>rk2</b>", "1 < 2"),), caption="R & D")
    markup = table_markup(table)
    assert "<caption>R &amp; D</caption>" in markup
    assert '<th scope="col">τ</th>' in markup
    assert '<th scope="row">&lt;b&gt;rk2&lt;/b&gt;</th><td>1 &lt; 2</td>' in markup


def test_a_table_without_rows_is_nothing():
    assert table_markup(Numbers(("integrator",), ())) == ""
