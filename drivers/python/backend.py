"""Builds the wheel and the sdist for pip (PEP 517), with the standard library alone.

The wheel has the package and its shared libraries. They come from build/python of the checkout where `make python` has
put them; where one is missing or older than the headers, a C compiler ($CC or cc) builds it. The sdist has the sources,
with both headers beside them: wheels can be built of it alone.

    python3 backend.py FOLDER  writes the sdist there
"""
import base64
import gzip
import hashlib
import io
import os
import re
import shlex
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE if (HERE / "pdcorr.h").exists() else HERE.parent.parent  # of an unpacked sdist, of a checkout
HEADERS = ("pdcorr_app.h", "pdcorr.h")  # the first includes the second
BUILT = ROOT / "build" / "python" / "pdcorr"
FLAGS = ["-std=c99", "-O3", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden",
         '-DPD_API=extern __attribute__((visibility("default")))', "-DPDCORR_IMPLEMENTATION", "-x", "c"]


def _library(dim: int, folder: Path) -> Path:
    built = BUILT / f"libpdcorr{dim}d.so"
    if built.exists() and all(
            built.stat().st_mtime >= (ROOT / name).stat().st_mtime for name in HEADERS):
        return built
    path = folder / built.name
    for openmp in (["-fopenmp"], []):  # as far as the compiler has it
        compiler = shlex.split(os.environ.get("CC", "cc"))
        command = [*compiler, *openmp, *FLAGS, f"-DPD_DIM={dim}", str(ROOT / HEADERS[0]), "-o", str(path), "-lm"]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        if done.returncode == 0:
            return path
    raise RuntimeError(f"{' '.join(command)}\n{done.stderr}")


def _version() -> str:
    header = (ROOT / "pdcorr.h").read_text(encoding="utf-8")
    return ".".join(re.search(rf"#define PD_VERSION_{part} (\d+)", header).group(1)
                    for part in ("MAJOR", "MINOR", "PATCH"))


def _sources() -> dict:
    """The package without its libraries."""
    return {f"pdcorr/{path.name}": path.read_bytes() for path in sorted((HERE / "pdcorr").glob("*.py*"))}


def _metadata(version: str) -> str:
    project = (HERE / "pyproject.toml").read_text(encoding="utf-8")
    value = lambda key: re.search(rf'^{key} = "(.*)"', project, re.MULTILINE).group(1)
    return (f"Metadata-Version: 2.1\nName: pdcorr\nVersion: {version}\nSummary: {value('description')}\n"
            f"Requires-Python: {value('requires-python')}\nRequires-Dist: numpy\nLicense: MIT\n"
            f"Description-Content-Type: text/markdown\n\n{(HERE / 'README.md').read_text(encoding='utf-8')}")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):  # pylint: disable=unused-argument
    """Write the wheel; its name."""
    version = _version()
    tag = f"py3-none-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    info, name = f"pdcorr-{version}.dist-info", f"pdcorr-{version}-{tag}.whl"
    with tempfile.TemporaryDirectory() as folder:
        files = _sources()
        for dim in (1, 2, 3):
            path = _library(dim, Path(folder))
            files[f"pdcorr/{path.name}"] = path.read_bytes()
    files[f"{info}/METADATA"] = _metadata(version).encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: pdcorr\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    record = ""
    with zipfile.ZipFile(Path(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record += f"{path},sha256={digest},{len(data)}\n"
            wheel.writestr(path, data)
        wheel.writestr(f"{info}/RECORD", f"{record}{info}/RECORD,,\n")
    return name


def build_sdist(sdist_directory, config_settings=None):  # pylint: disable=unused-argument
    """Write the sdist; its name. Its bytes depend on the sources alone."""
    version = _version()
    files = {"PKG-INFO": _metadata(version).encode(), **_sources(),
             **{name: (HERE / name).read_bytes() for name in ("README.md", "backend.py", "pyproject.toml")},
             **{name: (ROOT / name).read_bytes() for name in ("LICENSE", *HEADERS)}}
    name = f"pdcorr-{version}.tar.gz"
    with open(Path(sdist_directory, name), "wb") as out, gzip.GzipFile("", "wb", fileobj=out, mtime=0) as packed, \
            tarfile.open(mode="w", fileobj=packed, format=tarfile.PAX_FORMAT) as archive:
        for path, data in sorted(files.items()):
            member = tarfile.TarInfo(f"pdcorr-{version}/{path}")
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))
    return name


if __name__ == "__main__":
    print(build_sdist(sys.argv[1]))
