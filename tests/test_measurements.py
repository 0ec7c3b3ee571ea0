from pathlib import Path

import pytest

from skincad import check
from skincad.design import Design
from skincad.errors import InputError
from skincad.measurements import crest_drops
from skincad.section import frame


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "has no rows of numbers"),
        ("ridge,crest_mm\n", "has no rows of numbers"),
        ("ridge,height\n1,4.5\n", "unknown; known: crest_mm, ridge"),
        ("ridge,crest_m\n1,4.5\n", "did you mean 'crest_mm'"),
        ("ridge,crest_mm\n1,4.5\n", "must give crest_mm of each ridge from 1 to 9 once"),
        ("ridge,crest_mm\n1,4.5,3\n", "row 1: must have 2 values, got 3"),
        ("ridge,crest_mm\n1,high\n", "row 1: must be a finite number, got 'high'"),
        ("ridge,crest_mm\n1,nan\n", "row 1: must be a finite number, got 'nan'"),
        ("ridge,crest_mm\n" + "\n".join(f"{i},3.0" for i in range(1, 10)), "must be within 0.5 mm"),
    ],
)
def test_a_bad_file_is_refused_with_its_row_and_remedy(
    tmp_path: Path, yamada: Design, text: str, words: str
) -> None:
    path = tmp_path / "crests.csv"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        crest_drops(path, yamada)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def as_designed(path: Path, design: Design) -> Path:
    rows = [f"{r},{frame(design, r).at(0.0, design.ridge.height).z!r}" for r in range(1, 10)]
    path.write_text("ridge,crest_mm\n" + "\n".join(rows))
    return path


def test_a_missing_file_and_a_wrong_tier_are_refused(tmp_path: Path, yamada: Design) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        check(yamada, measured=tmp_path / "none.csv")
    with pytest.raises(InputError, match="--measured: is not judged by --tier winkler"):
        check(yamada, measured=as_designed(tmp_path / "crests.csv", yamada), tier="winkler")
