# Compile options that every target of the project shares.
add_library(godobject_options INTERFACE)
target_compile_definitions(godobject_options INTERFACE EIGEN_DONT_VECTORIZE)
target_compile_options(godobject_options INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wdouble-promotion -Wnon-virtual-dtor -Werror
  -fno-tree-vectorize -fno-tree-slp-vectorize  # see docs/decisions/010-no-eigen-packets.md
  -fno-math-errno -ffp-contract=$<IF:$<BOOL:${GODOBJECT_DETERMINISTIC}>,off,fast>)

if(GODOBJECT_DETERMINISTIC)
  set(march "")
elseif(GODOBJECT_MARCH STREQUAL "host")
  # The vector level, not the exact processor: a build stays readable on its neighbours.
  include(CheckCXXSourceRuns)
  set(CMAKE_REQUIRED_FLAGS "-march=x86-64-v3")
  check_cxx_source_runs("int main() { return __builtin_cpu_supports(\"avx2\") && __builtin_cpu_supports(\"fma\") ? 0 : 1; }"
                        GODOBJECT_HOST_IS_X86_64_V3)
  unset(CMAKE_REQUIRED_FLAGS)
  set(march "$<$<BOOL:${GODOBJECT_HOST_IS_X86_64_V3}>:-march=x86-64-v3>")
elseif(GODOBJECT_MARCH)
  set(march "-march=${GODOBJECT_MARCH}")
else()
  set(march "")
endif()
if(march)
  target_compile_options(godobject_options INTERFACE ${march})
endif()

if(GODOBJECT_NAN_INIT)
  target_compile_definitions(godobject_options INTERFACE EIGEN_INITIALIZE_MATRICES_BY_NAN)
endif()
if(GODOBJECT_SANITIZE)
  target_compile_options(godobject_options INTERFACE -fsanitize=${GODOBJECT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(godobject_options INTERFACE -fsanitize=${GODOBJECT_SANITIZE})
endif()
