#!/bin/bash
# bare_debian_use.sh WHEEL: installs the wheel into a new environment and runs everything of it, the programs beside this file among it.
# Called by bare_debian.sh in a system of its own.
set -euo pipefail
wheel=$1 programs=$(cd "$(dirname "$0")" && pwd)
python3 -m venv --system-site-packages /venv
PATH=/venv/bin:$PATH
pip install --quiet --no-index --no-deps "$wheel"
cd /work

# ends NAME SIZE: that a file is there and has at least so many bytes.
ends() { [[ $(stat -c %s "$1") -ge $2 ]] || { echo "$1 is too small" && exit 1; }; }
run() {
  echo "-- $*"
  python -I "$programs/$1" "${@:2}"
}

python -I -m bccsplat | tee told
grep -q 'package  *:* */venv/lib' told
bcc4 --version
run numpy_to_picture.py .
ends blob.png 2000
bcc4 info blob.bcc4 >/dev/null
bcc4 verify blob.bcc4
bcc4 render blob.bcc4 --time 0.5 -o tool.png
ends tool.png 2000
python -I -m bccsplat blob.bcc4 drawn.png
ends drawn.png 2000
run retime.py blob.bcc4 slow.bcc4 2 | tee told
grep -q '20 frames became 39' told
run compare_runs.py blob.bcc4 slow.bcc4 >apart.txt
[[ $(wc -l <apart.txt) -eq 22 ]]
run probes.py blob.bcc4 probes.csv 10,12,14 20,20,20
[[ $(wc -l <probes.csv) -eq 78 ]]
run film.py blob.bcc4 film.mp4 12
ends film.mp4 2000
run explore.py explore.bcc4 .
ends explore_oblique.png 2000
run xarray_dask.py blob.bcc4 anomaly.bcc4
bcc4 info anomaly.bcc4 >/dev/null
python -I -c 'import bccsplat, numpy; bccsplat.save("bound.bcc4", numpy.ones((9, 8, 8, 8)) * numpy.arange(8), psnr=50)'
bcc4 info bound.bcc4 >/dev/null
