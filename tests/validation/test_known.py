"""Known answers are met, and the page on them says what is computed."""

import re

import pytest

from tests.validation.known import CASES, page


@pytest.fixture(scope="module")
def rows(repository):
    text = (repository / "docs" / "validation.md").read_text(encoding="utf-8")
    return [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")][1:]


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_an_answer_is_met(case, rows):
    obtained = case.compute()
    assert case.error(obtained) <= case.bound
    (told,) = [row for row in rows if row[0] == case.name]
    assert float(told[2].split()[0]) == pytest.approx(obtained, rel=1e-4)


def test_the_page_has_the_cases_that_there_are(rows, repository):
    made = page({case: case.expected for case in CASES})
    text = (repository / "docs" / "validation.md").read_text(encoding="utf-8")

    def bare(words):
        return re.sub(r"^(\| [^|]+ \| [^|]+ \|)[^|]+\|[^|]+\|", r"\1", words, flags=re.MULTILINE)

    assert bare(made.partition("\n## More")[0]) == bare(text.partition("\n## More")[0])
    assert made.partition("\n## More")[2] == text.partition("\n## More")[2]
