// SPDX-License-Identifier: Apache-2.0
// Numbers as text, by the browser.
#include <emscripten.h>

EM_JS(void, bccsplat_write_number, (double value, int single, char* text), {
  let shortest = String(value);
  for (let digits = 1; single && digits < 10; ++digits) {
    shortest = String(Number(value.toPrecision(digits)));
    if (Math.fround(Number(shortest)) == value) break;
  }
  stringToUTF8(shortest, text, 64);
})
