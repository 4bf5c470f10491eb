"""What the browser needs for a picture is there, with its licences; tests/browser/test_export.py looks at pictures."""

from pathlib import Path

import pytest
from fontTools.ttLib import TTFont

import core
import pwsviz
from pwsviz.export import pictures
from pwsviz.export.pictures import CHOICES, PictureFiles, picture_callback
from pwsviz.figures.style import plain_figure

FOLDER = Path(pictures.__file__).parent


@pytest.mark.parametrize("name", PictureFiles._resources["files"])
def test_every_file_is_there_and_what_others_wrote_has_its_licence_beside_it(name):
    path = FOLDER / name
    assert path.stat().st_size > 1000
    if path.parent.name == "vendor":
        licence = path.with_name(f"{path.name.partition('.')[0].partition('-')[0]}.LICENSE")
        assert "copyright" in licence.read_text(encoding="utf-8").lower()


def test_the_code_of_a_button_names_its_figure_and_brings_no_library():
    plot = plain_figure("A line")
    code = picture_callback([plot])
    assert plot.id in code
    assert len(code) < 1500


def test_every_choice_has_its_default_among_its_options():
    assert all(0 <= usual < len(options) for _, options, usual in CHOICES.values())


FACES = ["PwsvizSans", "PwsvizSerif"]
"""The fonts, each with an upright and an italic face."""

NEVER_IN_A_PICTURE = {"☰", "ɏ"}
"""The sign of a menu, and the last letter of a range in the code."""


@pytest.mark.parametrize("font", FACES)
def test_the_font_of_a_pdf_has_every_character_that_the_page_may_say(font):
    folders = [Path(package.__file__).parent for package in (core, pwsviz)]
    sources = [path for folder in folders for ending in ("py", "js") for path in folder.rglob(f"*.{ending}")]
    said = {letter for path in sources if "vendor" not in path.parts for letter in path.read_text(encoding="utf-8")}
    known = TTFont(FOLDER / "vendor" / f"{font}-subset.ttf").getBestCmap()
    assert {letter for letter in said if letter.isprintable() and ord(letter) not in known} <= NEVER_IN_A_PICTURE


@pytest.mark.parametrize("font", FACES)
def test_the_slanted_font_of_a_pdf_has_every_letter_of_a_name_and_the_hat_above_it(font):
    known = TTFont(FOLDER / "vendor" / f"{font}-Italic-subset.ttf").getBestCmap()
    letters = {chr(code) for first, last in ("AZ", "az", "αω") for code in range(ord(first), ord(last) + 1)}
    assert {letter for letter in letters | {"\u02c6"} if ord(letter) not in known} == set()
