"""Snippets of a page of the docs, run one after another in a folder, as a reader would.

- A block of TOML, Python or CSV whose first line is a comment with a file name is written to that file;
  other Python runs in one namespace, and other TOML must be a scene.
- In a block of ``sh``, ``masonry-fem ...`` and ``python FILE ...`` run; a comment ``# exit code 3`` says how
  they end, if not with 0. Lines ``make``, ``pip``, ``cd`` and the like are not run.
- Each line of a block of ``text`` must have been printed since the page began.
"""

import re
import runpy
import shlex
import sys
from pathlib import Path

from masonry_fem import cli
from masonry_fem.scene import loads

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.S | re.M)
NAMED = re.compile(r"^# ([\w./]+\.\w+)\b[^\n]*\n")
KNOWN = {"python", "toml", "sh", "text", "csv"}


class Page:
    """A page whose snippets run.

    Parameters
    ----------
    text : Of the page. capsys : Of the test.
    """

    def __init__(self, text, capsys):
        self.blocks = BLOCK.findall(text)
        self._capsys, self._said = capsys, ""
        self.names = {"__name__": "__main__"}

    def run(self):
        """Run all of them in the current folder."""
        for kind, text in self.blocks:
            assert kind in KNOWN, f"a block of {kind} is not run; write one of {', '.join(sorted(KNOWN))}"
            getattr(self, f"_{kind}")(text)

    def _python(self, text):
        if NAMED.match(text):
            self._file(text)
        else:
            Path(".snippet.py").write_text(text, encoding="utf-8")  # tracebacks show its lines
            exec(compile(text, ".snippet.py", "exec"), self.names)

    def _toml(self, text):
        if NAMED.match(text):
            self._file(text)
        elif "[[structures]]" in text:
            loads(text)

    def _csv(self, text):
        self._file(text)

    def _file(self, text):
        name = NAMED.match(text)[1]
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(
            text if not name.endswith(".csv") else text.partition("\n")[2], encoding="utf-8"
        )

    def _sh(self, text):
        for line in text.replace("\\\n", " ").splitlines():
            told = re.search(r"# exit code (\d+)", line)
            words = shlex.split(line, comments=True)
            if words[:1] == ["masonry-fem"]:
                code = cli.main([*words[1:]])
                captured = self._capsys.readouterr()
                self._said += captured.out + captured.err
                assert code == (int(told[1]) if told else 0), f"{line}\n{captured.out}{captured.err}"
            elif words[:1] == ["python"] and words[1].endswith(".py"):
                before, sys.argv = sys.argv, words[1:]
                try:
                    runpy.run_path(words[1], run_name="__main__")
                finally:
                    sys.argv = before

    def _text(self, text):
        self._said += self._capsys.readouterr().out
        said = " ".join(self._said.split())
        for line in filter(str.strip, text.splitlines()):
            assert " ".join(line.split()) in said, f"not printed: {line}\n{self._said}"
