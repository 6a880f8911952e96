# Warnings and sanitizers for every target of the project.
add_library(bccsplat_flags INTERFACE)
target_compile_options(bccsplat_flags INTERFACE
  $<$<COMPILE_LANGUAGE:C,CXX>:-Wall -Wextra -Wconversion -Wshadow>
  # GCC 12 warns about "text" + std::string in its own header (PR 105651).
  $<$<AND:$<COMPILE_LANG_AND_ID:CXX,GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  $<$<BOOL:${BCCSPLAT_WERROR}>:-Werror>
  $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>
  -ffp-contract=off -fno-math-errno -fno-trapping-math)
if(BCCSPLAT_SANITIZE)
  target_compile_options(bccsplat_flags INTERFACE
    -fsanitize=${BCCSPLAT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  if(BCCSPLAT_SANITIZE MATCHES undefined)
    # A third of the time of compiling: what is behind a bad pointer, the address sanitizer sees where it is used.
    target_compile_options(bccsplat_flags INTERFACE -fno-sanitize=null,object-size,vptr)
    if(NOT BCCSPLAT_SANITIZE MATCHES alignment)
      # As much again, for what nightly looks at.
      target_compile_options(bccsplat_flags INTERFACE -fno-sanitize=alignment)
    endif()
  endif()
  if(BCCSPLAT_SANITIZE MATCHES float-)
    # Divisions by zero have a meaning where they are wanted: said everywhere, an error where UBSAN_OPTIONS=halt_on_error=1.
    target_compile_options(bccsplat_flags INTERFACE -fsanitize-recover=float-divide-by-zero,float-cast-overflow)
  endif()
  target_link_options(bccsplat_flags INTERFACE -fsanitize=${BCCSPLAT_SANITIZE})
endif()
