# Turns text files into C++ strings; run at build time:
#   cmake -DOUTPUT=FILE.cc -DHEADER=PATH "-DNAMES=kA;kB" "-DFILES=a.html;b.css" -P embed_files.cmake
# The strings are those that HEADER declares.
set(source "// Made by the build.\n#include \"${HEADER}\"\n\nnamespace arborslam {\n\n")
foreach(name file IN ZIP_LISTS NAMES FILES)
  file(READ "${file}" text)
  string(APPEND source "const std::string_view ${name} = R\"EMBEDDED(${text})EMBEDDED\";\n\n")
endforeach()
file(WRITE "${OUTPUT}" "${source}}  // namespace arborslam\n")
