# SPDX-License-Identifier: MIT
# Scenes and queries that tests and benchmarks share, each compiled once.
include_guard(GLOBAL)

# selvedge_shared(NAME SOURCES... LINK LIBRARIES...) makes the library selvedge_NAME.
function(selvedge_shared name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "" "LINK")
  list(TRANSFORM ARG_UNPARSED_ARGUMENTS PREPEND ${PROJECT_SOURCE_DIR}/)
  add_library(selvedge_${name} STATIC EXCLUDE_FROM_ALL ${ARG_UNPARSED_ARGUMENTS})
  selvedge_target_defaults(selvedge_${name})
  selvedge_precompile(selvedge_${name})
  target_compile_definitions(selvedge_${name} PRIVATE SELVEDGE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(selvedge_${name} PUBLIC ${ARG_LINK})
endfunction()

# Adversarial queries of the narrow phase with their verdicts.
selvedge_shared(ccd_queries tests/ccd_queries.cpp LINK selvedge::narrowphase selvedge::judge)
# Every internal force with a mesh for it.
selvedge_shared(force_cases tests/force_cases.cpp LINK selvedge::core)
# Cloth that starts with crossings.
selvedge_shared(tangles tests/tangles.cpp LINK selvedge::run selvedge::judge)
# Jaws that close on cloth.
selvedge_shared(grips tests/grips.cpp LINK selvedge::simulation)
