# Writes several test files into one translation unit:
#   cmake -D OUT=FILE -D ROOT=FOLDER -D "SOURCES=a.cpp b.cpp" -P batch_tests.cmake
# Headers, GoogleTest's above all, are then read once, and their templates are compiled once. Every
# file's unnamed namespace comes to stand in a namespace of its own: equal names of two files do not
# meet, as they do not when each is compiled by itself.
separate_arguments(SOURCES UNIX_COMMAND "${SOURCES}")
set(batch "")
set(number 0)
foreach(source IN LISTS SOURCES)
  math(EXPR number "${number} + 1")
  file(READ ${source} text)
  string(REPLACE "\nnamespace {\n" "\nnamespace file_${number} { namespace {\n" text "${text}")
  string(REPLACE "\n}  // namespace\n" "\n}}\n" text "${text}")
  # Relative, so that the compiler cache serves a clone at any place.
  file(RELATIVE_PATH name ${ROOT} ${source})
  string(APPEND batch "#line 1 \"${name}\"\n" "${text}")
endforeach()
file(WRITE ${OUT} "${batch}")
