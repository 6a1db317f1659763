#pragma once

#include <optional>
#include <string_view>

namespace headframe {

/// A file that is compiled into the server (server/operator/embed.cmake): the web page's files, and openapi.json.
struct EmbeddedFile {
  std::string_view path;  // as in the request, such as "/index.html"
  std::string_view content_type;
  std::string_view bytes;
  bool gzip = false;  // the bytes are compressed: index.html.gz is served as /index.html
};

/// "/" stands for "/index.html"; nullopt: there is no such file.
std::optional<EmbeddedFile> embedded_file(std::string_view path);

}  // namespace headframe
