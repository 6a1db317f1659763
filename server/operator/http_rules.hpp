#pragma once
// Checks of a request's header that are stricter than the parser's. A header that two programs could read differently
// is refused. All functions are pure.

#include <optional>
#include <string>
#include <string_view>

namespace headframe {

/// What is wrong with a received header that the parser accepted; nullopt: nothing. Faults are a field folded over
/// several lines, a transfer encoding other than chunked, both chunks and a length, more than one Host, and no Host in
/// HTTP/1.1.
std::optional<std::string> header_fault(std::string_view header);

/// Whether a server that requires no token may answer a request with this Host. DNS rebinding lets a foreign page reach
/// this address under the page's own name; so the host must be an address, a name without dots, or the name that the
/// server is served under.
bool own_host(std::string_view host, std::string_view served_under);

/// Whether a page of this origin is the server's own; with an empty origin the request did not come from a page. With
/// tls, a page that was loaded without TLS counts as foreign.
bool same_origin(std::string_view origin, std::string_view host, bool tls = false);

/// The name of the cookie for a page session. It contains the port, because cookies do not distinguish ports.
std::string page_cookie_name(std::string_view host);

/// The value of this cookie in a Cookie header; empty: it is not there.
std::string_view cookie_value(std::string_view cookies, std::string_view name);

}  // namespace headframe
