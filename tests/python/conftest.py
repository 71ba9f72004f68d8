import os
import pathlib

import pytest

import tendril

SCENES = pathlib.Path(os.environ.get("TENDRIL_SCENES", pathlib.Path(__file__).parents[2] / "scenes"))


@pytest.fixture
def scenes():
    return SCENES


@pytest.fixture
def brace():
    return tendril.load(SCENES / "brace.toml")
