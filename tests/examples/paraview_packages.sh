#!/bin/bash
# paraview_packages.sh FOLDER: unpacks Debian's ParaView, with what of its dependencies is not installed, into FOLDER/root and
# writes FOLDER/pvpython, which starts it on a screen of its own. The machine's packages stay as they are: python3-paraview
# excludes python3-vtk9, which other tests need. One that is there and runs stays.
set -euo pipefail
mkdir -p "${1:?usage: paraview_packages.sh FOLDER}"
out=$(cd "$1" && pwd)
runs() { "$out/pvpython" -c 'import paraview.simple'; }
if [[ -x $out/pvpython ]] && runs >/dev/null 2>&1; then exit 0; fi

# With lists of its own, for which nobody has to be root; what is installed counts as there.
as_apt() {
  apt-get -q -o Acquire::Retries=3 -o APT::Sandbox::User=root -o Debug::NoLocking=1 -o Dir::State="$out/apt" \
    -o Dir::State::status=/var/lib/dpkg/status -o Dir::State::lists="$out/apt/lists" -o Dir::Cache="$out/apt" "$@"
}
rm -rf "$out"/{apt,archives,root,python,pvpython}
mkdir -p "$out"/{apt/lists/partial,archives,root,python}
as_apt update
as_apt --simulate --no-install-recommends install paraview python3-paraview >"$out/apt/plan"
mapfile -t packages < <(sed -nE 's/^Inst ([^ ]+) (\[[^]]*\] )?\(([^ ]+) .*/\1=\3/p' "$out/apt/plan")
(cd "$out/archives" && as_apt download "${packages[@]}")
for package in "$out"/archives/*.deb; do
  dpkg-deb -x "$package" "$out/root"
done
rm -rf "$out"/{apt,archives}

# What Debian's ParaView 5.11 asks of Python 3.11: examples/paraview_plugin.py tells it to users.
cat >"$out/python/usercustomize.py" <<'PYTHON'
import inspect
inspect.getargspec = inspect.getfullargspec
PYTHON
# Without a display Debian's ParaView draws nothing, off-screen either.
cat >"$out/pvpython" <<SCRIPT
#!/bin/bash
export LD_LIBRARY_PATH=$out/root/usr/lib/x86_64-linux-gnu:$out/root/usr/lib
export PYTHONPATH=$out/python:$out/root/usr/lib/python3/dist-packages\${PYTHONPATH:+:\$PYTHONPATH}
exec xvfb-run -a -s "-screen 0 1280x1024x24" "$out/root/usr/bin/pvpython" --force-offscreen-rendering "\$@"
SCRIPT
chmod +x "$out/pvpython"
runs
