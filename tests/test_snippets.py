"""Every snippet of these pages runs, one after another, in an empty folder."""

from pathlib import Path

import pytest

from tests.snippets import Page

DOCS = Path(__file__).parents[1] / "docs"
PAGES = [DOCS / "python.md", *sorted(DOCS.glob("guides/*.md"))]


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_snippets_run(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    made = Page(page.read_text(encoding="utf-8"), capsys)
    assert made.blocks
    made.run()


def test_a_wrong_snippet_is_noticed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for text, said in (
        ('```python\nassert 1 == 2, "wrong"\n```\n', "wrong"),
        ("```sh\nmasonry-fem explain frction\n```\n", "frction"),
        ("```sh\nmasonry-fem explain friction\n```\n```text\nno such line\n```\n", "not printed"),
        ("```ruby\n1\n```\n", "is not run"),
    ):
        with pytest.raises(AssertionError, match=said):
            Page(text, capsys).run()
