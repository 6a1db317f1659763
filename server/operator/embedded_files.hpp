#pragma once

#include <optional>
#include <string_view>

namespace headframe {

/// A file that was compiled in (server/operator/embed.cmake): the page, and openapi.json.
struct EmbeddedFile {
  std::string_view path;  // "/index.html", as it is asked for
  std::string_view content_type;
  std::string_view bytes;
  bool gzip = false;  // bytes are compressed: index.html.gz is /index.html
};

/// "/" is "/index.html"; none: there is no such file.
std::optional<EmbeddedFile> embedded_file(std::string_view path);

}  // namespace headframe
