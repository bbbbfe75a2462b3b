# python: the Python package (drivers/python) on shared libraries of the tests' own objects, with $python, which has
# numpy; skips a test without it (Debian: python3-numpy). Sourced behind script.sh.

find_python 'import numpy, sys; assert sys.version_info >= (3, 9)'
[ "$python" ] || skip_all "numpy for Python is not installed"
export PDCORR_LIBRARY="$build/check" PDCORR_PROGRAMS="$programs" PYTHONDONTWRITEBYTECODE=1
export PYTHONPATH="$root/drivers/python${PYTHONPATH:+:$PYTHONPATH}"
