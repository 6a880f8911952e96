# bccsplat_precompile(TARGET [HEADER...]): compiles the headers that most files of a target include once for all of them,
# which takes a quarter off the time of a build (tests/bench/notes/build.md). Files include what they use nonetheless:
# builds with a compiler launcher go without this, for ccache does not trust precompiled headers unless it is told to.
set(precompile ON)
if(CMAKE_CXX_COMPILER_LAUNCHER OR BCCSPLAT_SANITIZE OR BCCSPLAT_BUILD_FUZZERS)
  set(precompile OFF)
endif()
option(BCCSPLAT_PRECOMPILE "Precompiled standard headers; by default where no compiler launcher is used" ${precompile})
function(bccsplat_precompile target)
  if(BCCSPLAT_PRECOMPILE)
    set(headers <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <functional> <limits> <map> <memory> <mutex>
      <optional> <span> <string> <utility> <vector> ${ARGN})
    list(TRANSFORM headers REPLACE "(.+)" "$<$<COMPILE_LANGUAGE:CXX>:\\1>")
    target_precompile_headers(${target} PRIVATE ${headers})
    # GCC 12 warns about its own <string>, which it no longer takes for a system header then (PR 105329).
    target_compile_options(${target} PRIVATE
      $<$<AND:$<COMPILE_LANG_AND_ID:CXX,GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-stringop-overflow>)
  endif()
endfunction()
