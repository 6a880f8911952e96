#!/bin/bash
# header_form_test.sh FORM: the check of the header's form finds what it is there for, and nothing in a header that is well.
set -euo pipefail
form=${1:?usage: header_form_test.sh FORM}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

passes() { bash "$form" "$scratch/header.h" || { echo "was refused: $1" && exit 1; }; }
refused() { ! bash "$form" "$scratch/header.h" >/dev/null || { echo "was not found: $1" && exit 1; }; }
header() { printf '%s\n' "$@" >"$scratch/header.h"; }

header '/* What' ' * it is. */' 'enum { /* of one line */' '  FIRST = 1, /* short */' '  LAST = 2' '};' \
  '#define VISIBLE __attribute__((visibility("default")))' 'VISIBLE int f(' '    int a, /* one */' '    int b);'
passes 'a header that is well'
header "/* $(printf 'x%.0s' {1..95}) */"
refused 'a line of 101 columns'
header 'struct s {' '  const char*' '      name;' '};'
refused 'a type above its name'
header 'int' 'f(void);'
refused 'a result above its function'
header 'struct s {' '  int a; /* which goes' '            on */' '};'
refused 'a comment beside a declaration that goes on'
