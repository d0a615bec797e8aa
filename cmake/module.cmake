# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
# evermap_module(NAME SOURCES... DEPENDS modules... LINKS external... [PRIVATE_LINKS external...] [FOLDER folder])
# One folder of src/evermap is one target; DEPENDS is the whole of what its headers may include (tests/layering
# checks the includes). FOLDER names the folder of a second target, for sources that need a package of their own.
function(evermap_module name)
  cmake_parse_arguments(ARG "" "FOLDER" "SOURCES;DEPENDS;LINKS;PRIVATE_LINKS" ${ARGN})
  if(NOT ARG_FOLDER)
    set(ARG_FOLDER ${name})
  endif()
  list(TRANSFORM ARG_SOURCES PREPEND "${PROJECT_SOURCE_DIR}/src/evermap/${ARG_FOLDER}/")
  add_library(evermap_${name} STATIC ${ARG_SOURCES})
  add_library(evermap::${name} ALIAS evermap_${name})
  set_target_properties(evermap_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(evermap_${name} PUBLIC cxx_std_20)
  target_include_directories(evermap_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  list(TRANSFORM ARG_DEPENDS PREPEND evermap_)
  target_link_libraries(evermap_${name} PUBLIC ${ARG_DEPENDS} ${ARG_LINKS}
    PRIVATE $<BUILD_INTERFACE:evermap_warnings> ${ARG_PRIVATE_LINKS})
  install(TARGETS evermap_${name} EXPORT evermap_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  set_property(GLOBAL APPEND PROPERTY EVERMAP_MODULES ${name})
endfunction()
