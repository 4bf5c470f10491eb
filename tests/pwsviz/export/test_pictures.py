"""What the browser needs for a picture is there, with its licences; tests/browser/test_export.py looks at pictures."""

from pathlib import Path

import pytest

from pwsviz.export import pictures
from pwsviz.export.pictures import CHOICES, PictureFiles, picture_callback
from pwsviz.figures.style import plain_figure

FOLDER = Path(pictures.__file__).parent


@pytest.mark.parametrize("name", PictureFiles._resources["files"])
def test_every_file_is_there_and_what_others_wrote_has_its_licence_beside_it(name):
    path = FOLDER / name
    assert path.stat().st_size > 1000
    if path.parent.name == "vendor":
        licence = path.with_name(
            f"{path.name.partition('.')[0].removesuffix('-subset').removesuffix('-Oblique')}.LICENSE"
        )
        assert "copyright" in licence.read_text(encoding="utf-8").lower()


def test_the_code_of_a_button_names_its_figure_and_brings_no_library():
    plot = plain_figure("A line")
    code = picture_callback([plot])
    assert plot.id in code
    assert len(code) < 1000


def test_every_choice_has_its_default_among_its_options():
    assert all(0 <= usual < len(options) for _, options, usual in CHOICES.values())
