# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
# evermap_link_pcl_registration(TARGET): links PCL's registration and defines EVERMAP_HAS_PCL, if PCL is there.
function(evermap_link_pcl_registration target)
  # Through pkg-config, because PCL's own package file also demands VTK's, which need not be complete.
  find_package(PkgConfig QUIET)
  if(PKG_CONFIG_FOUND)
    pkg_check_modules(PCL_REGISTRATION QUIET IMPORTED_TARGET pcl_registration pcl_filters)
  endif()
  if(PCL_REGISTRATION_FOUND)
    target_link_libraries(${target} PRIVATE PkgConfig::PCL_REGISTRATION)
    target_compile_definitions(${target} PRIVATE EVERMAP_HAS_PCL)
    # Inside PCL's templates.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-array-bounds>)
  endif()
endfunction()
