"""Builds the Python package: CMake makes the libraries, this puts them where the package finds them.

TENDRIL_BUILD_DIR: a build directory of CMake whose libraries are taken as they are; else one is made and built.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from setuptools import Distribution, Extension, setup
from setuptools.command.build_ext import build_ext

SOURCE = pathlib.Path(__file__).parent.resolve()


def version():
    text = (SOURCE / "core/include/tendril/version.hpp").read_text()
    return re.search(r'TENDRIL_VERSION "([0-9.]+)"', text)[1]


def built_by_cmake(temporary):
    """The directory of a finished build."""
    if given := os.environ.get("TENDRIL_BUILD_DIR"):
        return pathlib.Path(given)
    build = pathlib.Path(temporary).resolve() / "cmake"
    settings = {"CMAKE_BUILD_TYPE": "Release", "TENDRIL_TESTS": "OFF", "TENDRIL_BENCH": "OFF", "TENDRIL_PYTHON": "ON",
                "CMAKE_UNITY_BUILD": "ON", "TENDRIL_WERROR": "OFF",
                "TENDRIL_PYTHON_EXECUTABLE": sys.executable}
    configure = ["cmake", "-S", SOURCE, "-B", build, *(f"-D{key}={value}" for key, value in settings.items())]
    if shutil.which("ninja"):
        configure += ["-G", "Ninja"]
    subprocess.run(configure, check=True)
    subprocess.run(["cmake", "--build", build, "--parallel", str(os.cpu_count())], check=True)
    return build


class CMakeBuild(build_ext):
    def run(self):
        build = built_by_cmake(self.build_temp)
        package = pathlib.Path(self.get_ext_fullpath("tendril._native")).parent
        with tempfile.TemporaryDirectory() as directory:
            prefix = pathlib.Path(directory)
            subprocess.run(["cmake", "--install", build, "--prefix", prefix], check=True, stdout=subprocess.DEVNULL)
            (installed,) = prefix.glob("lib*/python3/dist-packages/tendril")
            shutil.copytree(installed, package, dirs_exist_ok=True)
            home = package / "home"
            shutil.rmtree(home, ignore_errors=True)
            (home / "lib").mkdir(parents=True)
            (home / "bin").mkdir()
            shutil.copy2(prefix / "bin/tendril", home / "bin")
            libraries = installed.parents[2]
            shutil.copytree(libraries / "tendril", home / "lib/tendril")
            # A wheel holds no links: each library under the one name by which it is looked for.
            for library in libraries.glob("libtendril*.so.[0-9]"):
                shutil.copy2(library, home / "lib", follow_symlinks=True)


class Binary(Distribution):
    def has_ext_modules(self):
        return True


setup(
    version=version(),
    packages=[],
    ext_modules=[Extension("tendril._native", [])],
    cmdclass={"build_ext": CMakeBuild},
    distclass=Binary,
)
