# Compiler settings, per target; nothing here reaches a user of the library but the sanitizers.

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES AND PROJECT_IS_TOP_LEVEL)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release, RelWithDebInfo" FORCE)
endif()
if(NOT CMAKE_CXX_STANDARD)  # our own sources stay C++17; users may compile theirs with a later one
  set(CMAKE_CXX_STANDARD 17)
endif()
set(CMAKE_CXX_EXTENSIONS OFF)
if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
endif()

find_program(HOLDFAST_CCACHE ccache)
mark_as_advanced(HOLDFAST_CCACHE)
if(HOLDFAST_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${HOLDFAST_CCACHE})
endif()

# Warnings; as errors with HOLDFAST_WERROR.
function(holdfast_compiler_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wpedantic $<$<BOOL:${HOLDFAST_WERROR}>:-Werror>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # psabi: the AVX kernels are chosen at run time and inlined, never called across files.
    # gcc 12 finds uninitialised members in Eigen's fixed-size temporaries where there are none, most of all with sanitizers.
    target_compile_options(${target} PRIVATE -Wno-psabi -Wno-maybe-uninitialized)
    if(HOLDFAST_SANITIZE)
      target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-stringop-overflow)
    endif()
  endif()
endfunction()

# Foreign headers that nearly every source of the target includes, parsed once. None of ours: a cached one would outlive its change.
# Sources include what they use all the same: preset minimal has no
# precompiled headers.
function(holdfast_precompile target)
  if(HOLDFAST_PCH)
    target_precompile_headers(${target} PRIVATE ${ARGN})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE -fpch-preprocess)  # lets ccache see through it
    endif()
  endif()
endfunction()

function(holdfast_sanitize target)
  if(HOLDFAST_SANITIZE)
    list(JOIN HOLDFAST_SANITIZE "," sanitizers)
    target_compile_options(${target} PUBLIC -fsanitize=${sanitizers} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${sanitizers})
    if("address" IN_LIST HOLDFAST_SANITIZE AND "undefined" IN_LIST HOLDFAST_SANITIZE)
      target_compile_options(${target} PUBLIC -fno-sanitize=null,vptr)  # the address sanitizer sees a null access; a third less to compile
    endif()
  endif()
endfunction()

function(holdfast_coverage target)
  if(HOLDFAST_COVERAGE)
    # Of these folders alone: without Eigen's and the tests' own lines half as long to run. Inlined after counting, so that no line is lost.
    target_compile_options(${target} PUBLIC --coverage -fprofile-update=atomic -fno-early-inlining
      "-fprofile-filter-files=(^|/)(graph|factors|solvers)/" -fprofile-exclude-files=/tests/)
    target_link_options(${target} PUBLIC --coverage)
  endif()
endfunction()
