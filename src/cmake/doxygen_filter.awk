# The header's plain comments as Doxygen reads them: one before a declaration belongs to it, one behind or below the
# start of a member's line to that member. The conventions at the top, below the licence, become the main page.
FNR == 1 { print ""; next }
FNR == 2 { sub(/\/\*/, "/** @mainpage"); print; in_mainpage = 1; next }
in_mainpage { if (/\*\//) in_mainpage = 0; print; next }
/^\/\* ---- .* ---- \*\/$/ { next }                       # section headings
/\{ \/\*/ { held = $0; sub(/\/\*.*/, "", held)            # `enum { /* what it is about`: before the enum
  comment = substr($0, index($0, "/*"))
  while (comment !~ /\*\//) { if ((getline line) <= 0) break; comment = comment "\n" line }
  sub(/\/\*/, "/**", comment)
  print comment; print held; next }
/^[[:space:]]*\/\*/ { sub(/\/\*/, "/**"); print; next }
/[^[:space:]].*\/\*/ { sub(/\/\*/, "/**<"); print; next }
{ print }
