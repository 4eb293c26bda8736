"""The wheel of the Python module: what CMake installs of its component `python`. All else is in pyproject.toml."""
import pathlib
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent
BUILD = ROOT / 'build'  # all that setuptools writes beside the wheel


class BuildByCMake(build_ext):
    """Configures, builds and installs into the folder that becomes the wheel."""

    def run(self):
        build, wheel = pathlib.Path(self.build_temp).absolute(), pathlib.Path(self.build_lib).absolute()
        subprocess.run(['cmake', '-S', ROOT, '-B', build, '-G', 'Ninja', '-DCMAKE_BUILD_TYPE=Release',
                        '-DTRUNNION_PYTHON=ON', '-DTRUNNION_WHEEL=ON', '-DTRUNNION_TESTS=OFF', '-DTRUNNION_BENCH=OFF',
                        f'-DPython_EXECUTABLE={sys.executable}'], check=True)
        subprocess.run(['cmake', '--build', build, '--target', 'trunnion_python'], check=True)
        subprocess.run(['cmake', '--install', build, '--component', 'python', '--prefix', wheel], check=True)


BUILD.mkdir(exist_ok=True)
setup(packages=[], options={'egg_info': {'egg_base': 'build'}}, ext_modules=[Extension('trunnion._core', [])],
      cmdclass={'build_ext': BuildByCMake})
