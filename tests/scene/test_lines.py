"""The line of every key of a TOML text."""

from masonry_fem.scene.lines import key_lines, line_of

TEXT = """\
a = 1 # a comment with = and [brackets]
b.c = "x = ] \\" ["
"d e" = '''
[no.table]
'''

[[f]]
g = [1,
     [2,  # two
      3],
]
[f.h]
i = { j = 1, k = { l = 2 } }
[[f]]
[[f.m]]
n = 1979-05-27T07:32:00Z
[f.h]
o = \"\"\"quoted "" text\"\"\"
p = 1
"""


def test_every_key_has_its_line():
    lines = key_lines(TEXT)
    assert lines == {
        ("a",): 1, ("b", "c"): 2, ("d e",): 3, ("f",): 7, ("f", 0): 7, ("f", 0, "g"): 8, ("f", 0, "g", 0): 8,
        ("f", 0, "g", 1): 9, ("f", 0, "g", 1, 0): 9, ("f", 0, "g", 1, 1): 10, ("f", 0, "h"): 12,
        ("f", 0, "h", "i"): 13, ("f", 0, "h", "i", "j"): 13, ("f", 0, "h", "i", "k"): 13,
        ("f", 0, "h", "i", "k", "l"): 13, ("f", 1): 14, ("f", 1, "m"): 15, ("f", 1, "m", 0): 15,
        ("f", 1, "m", 0, "n"): 16,
        ("f", 1, "h"): 17, ("f", 1, "h", "o"): 18, ("f", 1, "h", "p"): 19,
    }  # fmt: skip


def test_a_key_that_is_not_written_has_the_line_of_its_table():
    lines = key_lines(TEXT)
    assert line_of(lines, ("f", 1, "h", "missing")) == 17
    assert line_of(lines, ("nowhere",)) is None


def test_a_whole_array_of_tables_has_the_line_of_its_first():
    assert line_of(key_lines("a = 1\n[[b]]\nc = 1\n[[b]]\n"), ("b",)) == 2
