# headframe_embed(out PAGE_FILES): writes the .cpp of embedded_files.hpp for openapi.json and the files of the page, if any.
# Bytes are taken in by the assembler (.incbin), so that a large page costs no compile time.
function(headframe_embed out)
  set(files ${ARGN} ${CMAKE_CURRENT_SOURCE_DIR}/operator/openapi.json)
  set(page "")
  foreach(file IN LISTS ARGN)
    get_filename_component(name ${file} NAME)
    list(APPEND page /${name})
  endforeach()
  list(APPEND page /api/v1/openapi.json)
  set(data "")
  set(table "")
  set(index 0)
  foreach(path file IN ZIP_LISTS page files)
    string(REGEX REPLACE "\\.gz$" "" plain "${path}")
    if(plain STREQUAL path)
      set(gzip false)
    else()
      set(gzip true)
    endif()
    string(REGEX MATCH "[^.]*$" extension "${plain}")
    string(APPEND data "asm(\".pushsection .rodata\\nembedded_${index}: .incbin \\\"${file}\\\"\\nembedded_${index}_end:\\n.popsection\");\n"
      "extern \"C\" const char embedded_${index}[], embedded_${index}_end[];\n")
    string(APPEND table "    {\"${plain}\", type_of(\"${extension}\"), span(embedded_${index}, embedded_${index}_end), ${gzip}},\n")
    math(EXPR index "${index} + 1")
  endforeach()
  file(CONFIGURE OUTPUT ${out} CONTENT [=[// Made by server/operator/embed.cmake.
#include "server/operator/embedded_files.hpp"

@data@
namespace headframe {
namespace {

std::string_view span(const char* begin, const char* end) { return {begin, static_cast<std::size_t>(end - begin)}; }

std::string_view type_of(std::string_view extension) {
  if (extension == "html") return "text/html; charset=utf-8";
  if (extension == "js") return "text/javascript; charset=utf-8";
  if (extension == "css") return "text/css; charset=utf-8";
  if (extension == "json") return "application/json";
  if (extension == "svg") return "image/svg+xml";
  if (extension == "png") return "image/png";
  if (extension == "woff2") return "font/woff2";
  return "application/octet-stream";
}

}  // namespace

std::optional<EmbeddedFile> embedded_file(std::string_view path) {
  static const EmbeddedFile files[] = {
@table@  };
  if (path == "/") path = "/index.html";
  for (const EmbeddedFile& file : files)
    if (file.path == path) return file;
  return std::nullopt;
}

}  // namespace headframe
]=] @ONLY)
  # By itself: what a source of a unity build depends on is forgotten, and an old page would stay in the server.
  set_source_files_properties(${out} PROPERTIES OBJECT_DEPENDS "${files}" SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
