# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
# cmake -DROOT= -DBUILD= -DSOURCE= -DWORK= -DGENERATOR= -DCOMPILER= -DFLAGS= -DVERSION= -P check_core.cmake
# Configures and installs the core of ROOT where no package is found but Eigen and TBB (and xxHash, a library by its
# name), then builds and runs an example against it by the project SOURCE. Its libraries but one are those of BUILD: the same
# sources under the same flags, minutes ago. What is hidden here and needed there does not link.
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

set(hidden)
foreach(package IN ITEMS benchmark BZip2 CLI11 CycloneDDS embree fmt GTest nanoflann nlohmann_json octomap PkgConfig PNG rapidcheck spdlog SQLite3
    ufomap yaml-cpp ZLIB)
  list(APPEND hidden -DCMAKE_DISABLE_FIND_PACKAGE_${package}=TRUE)
endforeach()
set(common -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS} -DCMAKE_BUILD_TYPE=Debug
  -DCMAKE_CXX_FLAGS_DEBUG=-O0 ${hidden})
set(off -DEVERMAP_READ_GZIP=OFF)
foreach(part IN ITEMS APP BAGS BENCHMARKS CONFIG EVALUATION EXAMPLES HISTORY OCTOMAP ROS SIMULATION TESTS)
  list(APPEND off -DEVERMAP_BUILD_${part}=OFF)
endforeach()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -S ${ROOT} -B ${WORK}/core ${common} ${off} -DCMAKE_INSTALL_PREFIX=${WORK}/prefix)
file(GLOB libraries ${BUILD}/src/evermap/libevermap_*.a)
list(FILTER libraries EXCLUDE REGEX "libevermap_files")  # knows gzip there, and may not here
file(COPY ${libraries} DESTINATION ${WORK}/core/src/evermap)
run(${CMAKE_COMMAND} --build ${WORK}/core --target evermap_files)
run(${CMAKE_COMMAND} --install ${WORK}/core)
file(GLOB_RECURSE installed RELATIVE ${WORK}/prefix ${WORK}/prefix/*.a)
if(installed MATCHES "bags|config|evaluation|octomap|ros|simulation|web|yaml")
  message(FATAL_ERROR "the core alone has ${installed}")
endif()
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/consumer ${common} -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DEVERMAP_VERSION=${VERSION} -DEVERMAP_EXAMPLE=${ROOT}/examples/01_update_a_map.cpp)
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${CMAKE_COMMAND} -E chdir ${WORK} ${WORK}/consumer/core_consumer)
