# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""Builds the Python package by CMake, for pip."""
import os
import re
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCE = Path(__file__).parent.resolve()
VERSION = re.search(r"VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8").partition("project(")[2]).group(1)


class BuildByCMake(build_ext):
    def build_extension(self, extension):
        build = Path(self.build_temp).resolve()
        options = {"CMAKE_BUILD_TYPE": "Release", "Python_EXECUTABLE": sys.executable, "EVERMAP_BUILD_PYTHON": "ON",
                   "EVERMAP_BUILD_APP": "OFF", "EVERMAP_BUILD_TESTS": "OFF", "EVERMAP_BUILD_EXAMPLES": "OFF",
                   "EVERMAP_BUILD_BENCHMARKS": "OFF", "EVERMAP_BUILD_OCTOMAP": "OFF", "EVERMAP_BUILD_ROS": "OFF", "EVERMAP_BUILD_WEB": "OFF"}
        subprocess.run(["cmake", "-S", SOURCE, "-B", build, "-G", "Ninja", *(f"-D{k}={v}" for k, v in options.items())],
                       check=True)
        subprocess.run(["cmake", "--build", build, "--target", "evermap_python", "--parallel", str(os.cpu_count())], check=True)
        target = Path(self.get_ext_fullpath(extension.name)).resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        self.copy_file(next((build / "python" / "evermap").glob("_evermap*.so")), target)


setup(version=VERSION, packages=["evermap"], package_dir={"evermap": "python/evermap"},
      package_data={"evermap": ["*.pyi", "py.typed"]}, ext_modules=[Extension("evermap._evermap", sources=[])],
      cmdclass={"build_ext": BuildByCMake})
