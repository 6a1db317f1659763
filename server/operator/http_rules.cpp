#include "server/operator/http_rules.hpp"

#include <arpa/inet.h>

#include <algorithm>

namespace headframe {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same_word(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find("\r\n"), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 2, text.size()));
  return line;
}

bool is_address(const std::string& name) {
  in_addr v4{};
  in6_addr v6{};
  return ::inet_pton(AF_INET, name.c_str(), &v4) == 1 || ::inet_pton(AF_INET6, name.c_str(), &v6) == 1;
}

}  // namespace

std::optional<std::string> header_fault(std::string_view header) {
  const std::string_view request = take_line(header);
  int hosts = 0, encodings = 0, lengths = 0;
  while (!header.empty()) {
    const std::string_view line = take_line(header);
    if (line.empty()) break;
    if (line.front() == ' ' || line.front() == '\t') return "a field of its header is folded over two lines";
    const std::size_t colon = std::min(line.find(':'), line.size());
    const std::string_view name = line.substr(0, colon), value = trimmed(line.substr(std::min(colon + 1, line.size())));
    hosts += same_word(name, "Host") ? 1 : 0;
    lengths += same_word(name, "Content-Length") ? 1 : 0;
    if (!same_word(name, "Transfer-Encoding")) continue;
    if (++encodings > 1 || !same_word(value, "chunked")) return "its transfer encoding is not \"chunked\"";
  }
  if (encodings > 0 && lengths > 0) return "it has a length and comes in chunks";
  const bool newest = request.size() >= 8 && request.substr(request.size() - 8) == "HTTP/1.1";
  if (hosts > 1 || (newest && hosts == 0)) return "it needs one Host";
  return std::nullopt;
}

bool own_host(std::string_view host, std::string_view served_under) {
  std::string_view name = host.substr(0, host.rfind(':'));
  if (!host.empty() && host.front() == '[') {  // IPv6, with a port or without
    const std::size_t end = host.find(']');
    if (end == std::string_view::npos) return false;
    name = host.substr(1, end - 1);
  }
  return name.find('.') == std::string_view::npos || is_address(std::string(name)) || same_word(name, served_under);
}

bool same_origin(std::string_view origin, std::string_view host, bool tls) {
  if (origin.empty()) return true;
  const std::size_t scheme = origin.find("://");
  if (scheme == std::string_view::npos || (tls && origin.substr(0, scheme) != "https")) return false;
  return origin.substr(scheme + 3) == host;
}

std::string page_cookie_name(std::string_view host) {
  const std::size_t colon = host.rfind(':');
  const std::string_view port = colon == std::string_view::npos ? "" : host.substr(colon + 1);
  const bool is_port = !port.empty() && port.find_first_not_of("0123456789") == std::string_view::npos;
  return is_port ? "headframe-" + std::string(port) : "headframe";
}

std::string_view cookie_value(std::string_view cookies, std::string_view name) {
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    const std::string_view one = cookies.substr(0, end);
    if (one.size() > name.size() && one.substr(0, name.size()) == name && one[name.size()] == '=')
      return one.substr(name.size() + 1);
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
    cookies.remove_prefix(std::min(cookies.find_first_not_of(' '), cookies.size()));
  }
  return {};
}

}  // namespace headframe
