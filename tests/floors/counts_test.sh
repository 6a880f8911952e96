#!/bin/bash
# counts_test.sh SCRATCH: counts.sh accepts a small tree that its table tells, and says what became more, and what fewer.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
scratch=${1:?usage: counts_test.sh SCRATCH}

tree() {
  rm -rf "$scratch"
  mkdir -p "$scratch"/{src/base,formats/image,importers/tool,examples/python,include,tests/floors}
  printf '%s\n' 'int one = 1;' '// Of two, the first.' >"$scratch/src/base/one.cpp"
  printf '%s\n' 'int two = 2;' >"$scratch/formats/image/two.h"
  printf '%s\n' 'int main() { bccsplat_open(); }' >"$scratch/importers/tool/main.cpp"
  printf '%s\n' 'call("volume_close", 0)' >"$scratch/examples/python/volume.py"
  printf '%s\n' 'typedef struct s {' '  int a;' '  int b;' '} s;' 'BCCSPLAT_API int bccsplat_open(void);' \
    'BCCSPLAT_API int' '    bccsplat_volume_close(int volume);' 'BCCSPLAT_API int bccsplat_rare(void);' \
    >"$scratch/include/bccsplat.h"
  printf '%s\t%s\n' 1 'lines of formats/image' 1 'lines of importers/tool' 2 'lines of src/base' 3 calls 2 fields \
    1 'comments without a noun in front' 0 'uses of bccsplat_rare' >"$scratch/tests/floors/counts.tsv"
}

tree
bash "$here/counts.sh" "$scratch"

failures=0
grown() { # FILE LINE WHY: with this line in the file the report says why
  tree
  printf '%s\n' "$2" >>"$scratch/$1"
  if out=$(bash "$here/counts.sh" "$scratch"); then
    echo "FAILED: $1 may not say: $2" && failures=$((failures + 1))
  elif [[ $out != *"$3"* ]]; then
    echo "FAILED: the report does not say \"$3\": $out" && failures=$((failures + 1))
  fi
}
grown src/base/one.cpp 'int more = 2;' 'lines of src/base: 3, where the table says 2'
grown examples/host.c '/* Those of a host. */' 'comments without a noun in front: 2, where the table says 1'
grown include/bccsplat.h 'BCCSPLAT_API int bccsplat_new(void);' 'calls: 4, where the table says 3'
grown include/bccsplat.h 'BCCSPLAT_API int bccsplat_new(void);' 'uses of bccsplat_new: 0, not in the table'
grown include/bccsplat.h $'typedef struct t {\n  int c;\n} t;' 'fields: 3, where the table says 2'
grown examples/host.c 'int main(void) { return bccsplat_rare(); }' 'uses of bccsplat_rare: in the table, but no more'
tree && mkdir "$scratch/src/new" && echo 'int new = 1;' >"$scratch/src/new/new.cpp"
out=$(bash "$here/counts.sh" "$scratch") || true
[[ $out == *'lines of src/new: 1, not in the table'* ]] ||
  { echo "FAILED: a new room is not told: $out" && failures=$((failures + 1)); }

# Fewer lines hold; fewer of the rest are written down, so that they stay fewer.
tree && sed -i 1d "$scratch/src/base/one.cpp"
bash "$here/counts.sh" "$scratch" >/dev/null || { echo "FAILED: fewer lines do not hold" && failures=$((failures + 1)); }
echo 'int one;' >"$scratch/src/base/one.cpp"
if bash "$here/counts.sh" "$scratch" >/dev/null; then
  echo "FAILED: a comment that went is not told" && failures=$((failures + 1))
fi
bash "$here/counts.sh" "$scratch" --write >/dev/null
if ! bash "$here/counts.sh" "$scratch" >/dev/null || ! grep -q $'^1\tlines of src/base$' "$scratch/tests/floors/counts.tsv"; then
  echo "FAILED: --write does not tell what is there" && failures=$((failures + 1))
fi

rm -rf "$scratch"
[[ $failures == 0 ]] && echo "counts_test: all is found"
