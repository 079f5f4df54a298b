# Compiler settings and the small functions that every folder's CMakeLists.txt is written in.
include(GNUInstallDirs)
find_package(PkgConfig REQUIRED)

set(CMAKE_CXX_STANDARD 23)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_C_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo)
endif()
find_program(CCACHE ccache)
if(CCACHE)
  # Without this sloppiness it serves no file that uses precompiled headers.
  set(launcher ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${launcher})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${launcher})
endif()

# Off by default: another compiler knows other warnings, and no user's build should fail for one.
option(DDSSEC_WARNINGS_AS_ERRORS "Treat the compiler's warnings as errors" OFF)
add_library(ddssec_options INTERFACE)
target_compile_options(ddssec_options INTERFACE
  -Wall -Wextra -Wpedantic $<$<BOOL:${DDSSEC_WARNINGS_AS_ERRORS}>:-Werror>
  $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor -Woverloaded-virtual>
  # GNU-unique symbols would bind to whichever plugin was loaded first.
  $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fno-gnu-unique>
  # By default, g++ spends an eighth of its time on garbage collection.
  $<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=1000000>
  -fstack-protector-strong
  # Only x86-64 has it. It takes effect where the C library's start files have it too: Debian 13, not 12.
  $<$<STREQUAL:${CMAKE_SYSTEM_PROCESSOR},x86_64>:-fcf-protection=full>
  # No path of this machine in what is shipped: the same source gives the same bytes in each folder.
  "$<$<CONFIG:Release>:-ffile-prefix-map=${PROJECT_SOURCE_DIR}=.;-ffile-prefix-map=${CMAKE_BINARY_DIR}=build>")
# All addresses of other libraries are looked up at start, and what holds them is read-only from then on.
target_link_options(ddssec_options INTERFACE -Wl,-z,relro,-z,now)
if(DDSSEC_SANITIZE)
  add_compile_options(-fsanitize=${DDSSEC_SANITIZE} -fno-omit-frame-pointer
                      -fno-sanitize-recover=all
                      # g++ 12 warns of its own instrumentation.
                      $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-maybe-uninitialized>)
  if(DDSSEC_SANITIZE STREQUAL "thread")  # it does not see fences, of which g++ warns
    add_compile_options($<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-tsan>)
  endif()
  add_link_options(-fsanitize=${DDSSEC_SANITIZE})
else()  # the sanitizers do not check __memcpy_chk and the like, which this calls
  target_compile_options(ddssec_options INTERFACE
    $<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2>)
endif()
# How much longer a test may take with sanitizers; in code, tests/support/slowdown.hpp.
set(DDSSEC_SLOWDOWN 1)
if(DDSSEC_SANITIZE)
  set(DDSSEC_SLOWDOWN 10)
endif()
# ddssec_test_unfit_for_sanitizers(TEST REASON): under them ctest names it as disabled.
function(ddssec_test_unfit_for_sanitizers test reason)
  if(DDSSEC_SANITIZE)
    message(STATUS "${test} does not run sanitized: ${reason}")
    set_tests_properties(${test} PROPERTIES DISABLED TRUE)
  endif()
endfunction()

# ddssec_preload_sanitizer(TESTS ...): for tests in which a stock program loads our plugins, or in which another
# library is preloaded. The runtime of the address sanitizer is preloaded into their processes, and need not be first.
# Stock programs leak, and ROS 2 deletes objects with another size: only our own programs, which have a file in
# build/asan/own-programs, check for both.
# Call it after the other properties of the tests are set.
function(ddssec_preload_sanitizer)
  if(DDSSEC_SANITIZE MATCHES "address")
    execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=libasan.so
                    OUTPUT_VARIABLE runtime OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    set(lenient "detect_leaks=0:new_delete_type_mismatch=0:verify_asan_link_order=0")
    set_property(TEST ${ARGN} APPEND PROPERTY ENVIRONMENT "LD_PRELOAD=${runtime}"
                 "ASAN_OPTIONS=${lenient}:include_if_exists=${CMAKE_BINARY_DIR}/own-programs/%b")
  elseif(DDSSEC_SANITIZE)
    foreach(test ${ARGN})
      ddssec_test_unfit_for_sanitizers(${test} "only the address sanitizer is preloaded into stock programs")
    endforeach()
  endif()
endfunction()

# ddssec_check_own_programs(FOLDER): names the sanitized programs of a folder and those below it, for
# ddssec_preload_sanitizer.
function(ddssec_check_own_programs folder)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    get_target_property(is_stock ${target} DDSSEC_NOT_SANITIZED)
    if(type STREQUAL "EXECUTABLE" AND NOT is_stock)
      file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/own-programs/$<TARGET_FILE_NAME:${target}>
           CONTENT "detect_leaks=1\nnew_delete_type_mismatch=1\n")
    endif()
  endforeach()
  get_property(below DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(child ${below})
    ddssec_check_own_programs(${child})
  endforeach()
endfunction()

if(DDSSEC_BUILD_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)  # what is fuzzed tells which branches it took
  add_compile_definitions(_GLIBCXX_ASSERTIONS)
endif()

# ddssec_not_sanitized(TARGETS...): for what a stock program loads, or what holds none of our code
# and is made of a product that does not pass.
function(ddssec_not_sanitized)
  if(DDSSEC_SANITIZE)
    foreach(target ${ARGN})
      target_compile_options(${target} PRIVATE -fno-sanitize=all)
      target_link_options(${target} PRIVATE -fno-sanitize=all)
      set_target_properties(${target} PROPERTIES DDSSEC_NOT_SANITIZED TRUE)
    endforeach()
  endif()
endfunction()

# Reading the standard library's headers is half of what compiling a file of a library costs. Every file
# still includes what it uses: the preset asan compiles without.
option(DDSSEC_PRECOMPILE "Precompile the headers that most files of the libraries include" ON)
set(ddssec_common_headers <algorithm> <array> <atomic> <bitset> <chrono> <cstdint> <deque> <expected>
    <filesystem> <functional> <limits> <map> <memory> <mutex> <optional> <ranges> <set> <span> <string>
    <string_view> <unordered_map> <variant> <vector>)

# How many files are compiled as one; 1 is for working on one file.
set(DDSSEC_BATCH 8 CACHE STRING "Files that are compiled as one; 1 compiles each by itself")
# The same for tests: most of their time is that of GoogleTest's and the product's templates. A batch of 24 files
# needs up to 2 GB of memory.
set(DDSSEC_TEST_BATCH 48 CACHE STRING "Test files that are compiled as one; 1 compiles each by itself")

# ddssec_join_files(TARGET SOURCES...): compiles files of one folder together, so that the templates which
# many of them use are compiled once. Their unnamed namespaces become one: names in them must differ.
function(ddssec_join_files target)
  if(DDSSEC_BATCH LESS_EQUAL 1)
    return()
  endif()
  foreach(source ${ARGN})
    get_filename_component(folder ${source} DIRECTORY)
    get_filename_component(folder "${folder}" NAME)
    string(MAKE_C_IDENTIFIER "in_${folder}" folder)
    math(EXPR batch "${count_${folder}} + 0")
    math(EXPR count_${folder} "${batch} + 1")
    math(EXPR batch "${batch} / ${DDSSEC_BATCH}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${folder}_${batch})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # Joined files count as headers, whose classes must not hold what only one file knows.
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage>)
endfunction()

# ddssec_compile_quickly(TARGETS ...): code of commands, which runs once. Compiling it takes a third less.
function(ddssec_compile_quickly)
  foreach(target ${ARGN})
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endforeach()
endfunction()

# ddssec_library(NAME SOURCES ... [PUBLIC libs ...] [PRIVATE libs ...] [PRECOMPILE headers ...] [ALONE files ...]
#                [QUICK])
# ALONE: sources that are not joined with others, since they use the same short names for different things.
# QUICK: as ddssec_compile_quickly.
# A static library ddssec_NAME whose headers are included as "folder/file.hpp" from the root.
function(ddssec_library name)
  cmake_parse_arguments(ARG "QUICK" "" "SOURCES;PUBLIC;PRIVATE;PRECOMPILE;ALONE" ${ARGN})
  add_library(ddssec_${name} STATIC ${ARG_SOURCES})
  add_library(ddssec::${name} ALIAS ddssec_${name})
  set_property(GLOBAL APPEND PROPERTY DDSSEC_LIBRARIES ${name})
  target_include_directories(ddssec_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/ddssec>)
  target_compile_features(ddssec_${name} PUBLIC cxx_std_23)  # their headers need it
  target_link_libraries(ddssec_${name} PUBLIC ${ARG_PUBLIC}
                        PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:ddssec_options>)
  target_compile_options(ddssec_${name} PRIVATE
                         "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wshadow;-Wconversion;-Wmissing-declarations>")
  if(ARG_QUICK)
    ddssec_compile_quickly(ddssec_${name})
  endif()
  list(LENGTH ARG_SOURCES files)
  if(files GREATER 4)
    set(joined ${ARG_SOURCES})
    list(REMOVE_ITEM joined ${ARG_ALONE} "")
    ddssec_join_files(ddssec_${name} ${joined})
  endif()
  if(DDSSEC_PRECOMPILE AND files GREATER 4)
    set(headers ${ddssec_common_headers} ${ARG_PRECOMPILE})
    set(kind plain)
    if("fmt::fmt" IN_LIST ARG_PRIVATE OR "fmt::fmt" IN_LIST ARG_PUBLIC)
      list(APPEND headers <fmt/format.h>)
      set(kind fmt)
    endif()
    if(ARG_QUICK)
      string(APPEND kind _quick)
    endif()
    # What the first library of a kind has precompiled serves all that need no headers besides.
    get_property(first GLOBAL PROPERTY ddssec_precompiled_${kind})
    if(ARG_PRECOMPILE)
      target_precompile_headers(ddssec_${name} PRIVATE ${headers})
    elseif(first)
      target_precompile_headers(ddssec_${name} REUSE_FROM ${first})
    else()
      target_precompile_headers(ddssec_${name} PRIVATE ${headers})
      set_property(GLOBAL PROPERTY ddssec_precompiled_${kind} ddssec_${name})
    endif()
    # So that the compiler cache sees what the precompiled header was made of.
    target_compile_options(ddssec_${name} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fpch-preprocess>)
  endif()
endfunction()

# ddssec_batches(OUT TARGET SOURCES...): OUT is what TARGET is compiled from. Files *_test.cpp are joined
# by batch_tests.cmake, in as few batches of about equal length as DDSSEC_TEST_BATCH files of 6,000 octets fill.
function(ddssec_batches out target)
  set(tests ${ARGN})
  list(FILTER tests INCLUDE REGEX "^[^/]*_test\\.cpp$")
  list(LENGTH tests count)
  if(DDSSEC_TEST_BATCH LESS_EQUAL 1 OR count LESS_EQUAL 1)
    set(${out} ${ARGN} PARENT_SCOPE)
    return()
  endif()
  set(result ${ARGN})
  list(REMOVE_ITEM result ${tests})
  list(TRANSFORM tests PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  set(octets 0)
  foreach(test IN LISTS tests)
    file(SIZE ${test} size)
    math(EXPR octets "${octets} + ${size}")
  endforeach()
  math(EXPR most "6000 * ${DDSSEC_TEST_BATCH}")
  math(EXPR batches "(${octets} + ${most} - 1) / ${most}")
  set(before 0)
  foreach(test IN LISTS tests)
    math(EXPR number "${before} * ${batches} / ${octets} + 1")
    list(APPEND batch_${number} ${test})
    file(SIZE ${test} size)
    math(EXPR before "${before} + ${size}")
  endforeach()
  set(script ${PROJECT_SOURCE_DIR}/cmake/batch_tests.cmake)
  foreach(number RANGE 1 ${batches})
    set(batch ${batch_${number}})
    if(NOT batch)  # a long file before has taken its place
      continue()
    endif()
    set(file ${CMAKE_CURRENT_BINARY_DIR}/${target}_${number}.cpp)
    list(JOIN batch " " sources)
    add_custom_command(OUTPUT ${file} DEPENDS ${batch} ${script} VERBATIM
                       COMMAND ${CMAKE_COMMAND} -D OUT=${file} -D ROOT=${PROJECT_SOURCE_DIR}
                               -D "SOURCES=${sources}" -P ${script}
                       COMMENT "Joining tests of ${target} (${number} of ${batches})")
    list(APPEND joined ${file})
  endforeach()
  # By itself, joining waits for none of the libraries that the target links.
  add_custom_target(${target}_batches DEPENDS ${joined})
  set(result ${joined} ${result})
  set(${out} ${result} PARENT_SCOPE)
endfunction()

# ddssec_precompile_test(TARGET): the first one precompiles GoogleTest's headers for all.
function(ddssec_precompile_test target)
  get_property(first GLOBAL PROPERTY ddssec_precompiled_test)
  if(first)
    target_precompile_headers(${target} REUSE_FROM ${first})
  else()
    target_precompile_headers(${target} PRIVATE ${ddssec_common_headers} <gmock/gmock.h> <gtest/gtest.h>)
    set_property(GLOBAL PROPERTY ddssec_precompiled_test ${target})
  endif()
  target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-fpch-preprocess>)
endfunction()

# ddssec_compile_as_test(TARGET): what is tested is optimised; the tests themselves only have to compile quickly.
function(ddssec_compile_as_test target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-Og>
                         "$<$<CONFIG:RelWithDebInfo>:-O1;-g1>"
                         # g++ warns of more than there is when it optimises little.
                         $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-maybe-uninitialized>)
  if(DDSSEC_PRECOMPILE AND NOT DDSSEC_SANITIZE)
    ddssec_precompile_test(${target})
  endif()
endfunction()

# One process for many tests makes what they share once, such as a PKI. One for each costs a start each.
option(DDSSEC_TEST_EACH "Make an entry of ctest for each test of GoogleTest, named FOLDER.Suite.Test" OFF)
# scripts/cross.sh leaves some out by their names, and a program ends at the first report of a sanitizer.
if(CMAKE_CROSSCOMPILING OR DDSSEC_SANITIZE)
  set(DDSSEC_TEST_EACH ON)
endif()

# ddssec_test(NAME SOURCES ... LIBS ... [LABELS ...] [LONG filter] [ALONE filter] [EACH] [SHARDS number])
# A GoogleTest program test_NAME. One entry of ctest, "NAME.tests", runs its tests in one process. Tests that fit the
# filter of LONG are an entry each, with the label "long" too.
# SHARDS: so many entries, "NAME.tests_1" and so on, run a part of the tests each.
# ALONE: what fits this filter needs a process for each test, which becomes an entry "NAME.Suite.Case".
# EACH: so does every test of the program. DDSSEC_TEST_EACH makes it so for all programs.
function(ddssec_test name)
  cmake_parse_arguments(ARG "EACH" "LONG;ALONE;SHARDS" "SOURCES;LIBS;LABELS" ${ARGN})
  ddssec_batches(sources test_${name} ${ARG_SOURCES})
  add_executable(test_${name} ${sources})
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(test_${name} PRIVATE ${ARG_LIBS} ddssec_test_data GTest::gmock
                        GTest::gtest_main ddssec_options)
  ddssec_compile_as_test(test_${name})
  if(ARG_EACH OR DDSSEC_TEST_EACH)
    if(ARG_LONG)
      ddssec_discover_tests(${name} "-${ARG_LONG}" unit ${ARG_LABELS})
      ddssec_discover_tests(${name} "${ARG_LONG}" unit ${ARG_LABELS} long)
    else()
      ddssec_discover_tests(${name} "*" unit ${ARG_LABELS})
    endif()
    return()
  endif()
  set(others ${ARG_LONG} ${ARG_ALONE})
  list(JOIN others ":" others)
  if(ARG_ALONE)
    ddssec_discover_tests(${name} "${ARG_ALONE}" unit ${ARG_LABELS})
  endif()
  if(ARG_LONG)
    ddssec_discover_tests(${name} "${ARG_LONG}" unit ${ARG_LABELS} long)
  endif()
  if(NOT ARG_SHARDS)
    set(ARG_SHARDS 1)
  endif()
  ddssec_group_tests(${name} "*-${others}" ${ARG_SHARDS} unit ${ARG_LABELS})
endfunction()

# ddssec_group_tests(NAME FILTER SHARDS LABELS ...): the tests of test_NAME that fit GoogleTest's filter, as
# SHARDS entries.
function(ddssec_group_tests name filter shards)
  # test_group.py ends the program itself, to name the test that did not end.
  set(seconds 600)
  set(timeout 660)
  foreach(shard RANGE 1 ${shards})
    set(entry ${name}.tests)
    if(shards GREATER 1)
      string(APPEND entry _${shard})
    endif()
    math(EXPR index "${shard} - 1")
    add_test(NAME ${entry}
             COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/tests/support/test_group.py
                     ${CMAKE_BINARY_DIR}/Testing/Temporary/groups/${entry} ${name} ${seconds}
                     $<TARGET_FILE:test_${name}> "--gtest_filter=${filter}")
    # The long ones begin early, as ddssec_long_tests lets others do.
    set_tests_properties(${entry} PROPERTIES LABELS "${ARGN}" TIMEOUT ${timeout} COST 80 ENVIRONMENT
                         "GTEST_TOTAL_SHARDS=${shards};GTEST_SHARD_INDEX=${index}")
  endforeach()
endfunction()

# ddssec_discover_tests(NAME FILTER LABELS ...): the tests of test_NAME that fit GoogleTest's filter.
function(ddssec_discover_tests name filter label)
  math(EXPR timeout "120 * ${DDSSEC_SLOWDOWN}")
  string(MAKE_C_IDENTIFIER "${name}_${label}_${ARGN}_tests" list)
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}. TEST_FILTER "${filter}" DISCOVERY_TIMEOUT 60
                       TEST_LIST ${list} PROPERTIES LABELS ${label} TIMEOUT ${timeout})
  if(ARGN)  # PROPERTIES cannot hold a list.
    set(file ${CMAKE_CURRENT_BINARY_DIR}/${list}.cmake)
    file(WRITE ${file} "set_tests_properties(\${${list}} PROPERTIES LABELS \"${label};${ARGN}\")\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${file})
  endif()
endfunction()
