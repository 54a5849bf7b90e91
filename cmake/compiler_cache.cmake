# Puts ccache, where it is installed, before the compiler. A clone in another folder finds what an earlier one compiled:
# paths below the sources count as relative ones, precompiled headers by what they contain.
option(ACUS_COMPILER_CACHE "Compile with ccache where it is installed" ON)
find_program(CCACHE ccache)
mark_as_advanced(CCACHE)
if(ACUS_COMPILER_CACHE AND CCACHE)
  foreach(language C CXX)
    set(CMAKE_${language}_COMPILER_LAUNCHER
        ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
        CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
  endforeach()
endif()
