"""Build the zip of the Blender extension, with the packages that it needs as wheels.

    python extras/blender/build.py [--platforms linux-x64 windows-x64 macos-arm64] [--without-wheels] [-o build/blender]

One zip a platform: in Blender, Edit > Preferences > Get Extensions > Install from Disk. Blender 4.2 to 5.0 has Python
3.11 and brings numpy; the wheels of scipy, shapely, clarabel and mapbox-earcut come from PyPI in the versions that
requirements.lock names, and that of blockstat from this checkout.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SOURCE = HERE / "blockstat_extension"
#: What a verdict imports beside numpy.
PACKAGES = ("scipy", "shapely", "clarabel", "mapbox-earcut")
PYTHON = "3.11"
#: Tags of wheels by Blender's name of a platform.
PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_12_0_arm64", "macosx_11_0_arm64"),
}


def versions() -> list[str]:
    """The packages with their versions of requirements.lock."""
    rows = re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "requirements.lock").read_text(), re.MULTILINE)
    locked = {name.replace("_", "-").lower(): version for name, version in rows}
    return [f"{name}=={locked[name]}" for name in PACKAGES]


def pip(*words: str | Path) -> None:
    subprocess.run(
        [sys.executable, "-m", "pip", *map(str, words), "--quiet", "--disable-pip-version-check"], check=True
    )


def fetch(platform: str, place: Path) -> None:
    """The wheels of a platform."""
    tags = [word for tag in PLATFORMS[platform] for word in ("--platform", tag)]
    pip(
        "download", "--no-deps", "--only-binary=:all:", "--python-version", PYTHON, "--implementation", "cp",
        *tags, "--dest", place, *versions(),
    )  # fmt: skip
    shutil.rmtree(ROOT / "build" / "lib", ignore_errors=True)  # setuptools would take old modules from there
    pip("wheel", "--no-deps", "--wheel-dir", place, ROOT)


def manifest(platform: str, wheels: list[Path]) -> str:
    """The manifest with its platform and its wheels."""
    text = (SOURCE / "blender_manifest.toml").read_text()
    listed = "".join(f'  "./wheels/{own.name}",\n' for own in wheels)
    return text + f'platforms = ["{platform}"]\n' + (f"wheels = [\n{listed}]\n" if wheels else "")


def build(platform: str, output: Path, *, with_wheels: bool = True) -> Path:
    """The zip of a platform."""
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        if with_wheels:
            fetch(platform, place)
        wheels = sorted(place.glob("*.whl"))
        version = re.search(r'^version = "(.*)"', (SOURCE / "blender_manifest.toml").read_text(), re.MULTILINE)
        path = output / f"blockstat-{version[1]}-{platform}.zip"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as made:
            made.writestr("blender_manifest.toml", manifest(platform, wheels))
            made.write(ROOT / "LICENSE", "LICENSE")
            for module in sorted(SOURCE.glob("*.py")):
                made.write(module, module.name)
            for own in wheels:
                made.write(own, f"wheels/{own.name}", zipfile.ZIP_STORED)
    return path


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--platforms", nargs="+", choices=PLATFORMS, default=list(PLATFORMS))
    parser.add_argument("--without-wheels", action="store_true", help="for Blenders whose Python has the packages")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "build" / "blender")
    given = parser.parse_args()
    for platform in given.platforms:
        path = build(platform, given.output, with_wheels=not given.without_wheels)
        print(f"{path}: {path.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
