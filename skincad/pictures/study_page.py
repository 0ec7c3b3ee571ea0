"""A study as one page that needs nothing else: a table that sorts, two results against each other, and each
row's design to copy."""

from __future__ import annotations

import json
from html import escape
from typing import Any

from skincad.pictures.page import HERE, document


def page(title: str, words: str, data: dict[str, Any]) -> str:
    """Return an HTML document of a table, a plot of two of its columns, and each row's design.

    `data` has `head` (names of columns), `rows`, `refused` (whether each is), `designs` (a text each), and
    `x` and `y`, the columns that are plotted first.
    """
    script = (HERE / "study.js").read_text("utf-8")
    data_json = json.dumps(data, allow_nan=False).replace("<", "\\u003c")
    body = f"""<h1>{escape(title)}</h1>
<pre>{escape(words)}</pre>
<div class="row">
<div class="column">
<p><label>across <select id="x"></select></label><label>up <select id="y"></select></label>
<label>colour <select id="colour"></select></label></p>
<svg id="plot" width="580" height="350" viewBox="0 0 580 350"></svg>
</div>
<div class="column">
<p><b id="which">Click a row or a point for its design</b> <button id="copy">copy</button></p>
<textarea id="design" readonly></textarea>
</div>
</div>
<p>Click a column's head to sort by it.</p>
<div class="table"><table><thead><tr id="head"></tr></thead><tbody id="rows"></tbody></table></div>
<script type="application/json" id="data">{data_json}</script>
<script>
{script}</script>
"""
    return document(title, body, "study.css")
