# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
# evermap_precompile(TARGET library|program|test): parses Eigen and the standard library (and GoogleTest) once a kind
# instead of once a file. Sources are also compiled several at a time, since the headers that they share (Eigen, CLI11,
# JSON) make most of the code of each. It only saves time: the preset clang builds without, and there a
# missing include shows.
# One precompiled header serves only targets of the same flags, which is why libraries (-fPIC) have their own.
function(evermap_precompile target kind)
  set(headers <algorithm> <array> <cmath> <cstddef> <cstdint> <filesystem> <functional> <limits> <map> <memory> <numeric>
    <optional> <span> <sstream> <stdexcept> <string> <string_view> <utility> <vector>
    <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU>)
  set(precompiled evermap_precompiled_${kind})
  if(NOT TARGET ${precompiled})
    set(source ${PROJECT_BINARY_DIR}/precompiled/${kind}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "")
    add_library(${precompiled} OBJECT ${source})
    target_compile_features(${precompiled} PRIVATE cxx_std_20)
    target_link_libraries(${precompiled} PRIVATE Eigen3::Eigen evermap_warnings)
    if(kind STREQUAL "library")
      set_target_properties(${precompiled} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    elseif(kind STREQUAL "program")
      list(APPEND headers <nlohmann/json.hpp>)
    elseif(kind STREQUAL "test")
      list(APPEND headers <gtest/gtest.h>)
      target_link_libraries(${precompiled} PRIVATE GTest::gtest)
    endif()
    target_precompile_headers(${precompiled} PRIVATE ${headers})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${precompiled})
  if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON)
  endif()
endfunction()
