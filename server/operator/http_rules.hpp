#pragma once
// What a request's header has to be beyond what the parser asks: where two programs could read it differently, it is
// refused.

#include <optional>
#include <string>
#include <string_view>

namespace headframe {

/// What is wrong with a header, as it came, that the parser let through; nullopt: nothing. A field folded over lines, a
/// transfer encoding other than chunked, chunks beside a length, and of HTTP/1.1 anything but one Host. Pure.
std::optional<std::string> header_fault(std::string_view header);

/// Whether a request with this Host may be answered by a server that asks for no token: a browser may be led to this
/// address under a stranger's name. An address, a name without dots, or the name that the server is served under.
bool own_host(std::string_view host, std::string_view served_under);

/// Whether a page of this origin is the server's own; an empty one: no browser sent it. tls: it was asked over TLS,
/// where a page that came in the clear is a stranger's.
bool same_origin(std::string_view origin, std::string_view host, bool tls = false);

/// The cookie of a page's session: cookies do not tell ports apart, so each has a name of its own. Pure, as the next.
std::string page_cookie_name(std::string_view host);

/// The value of the cookie in a Cookie header; empty: it is not there.
std::string_view cookie_value(std::string_view cookies, std::string_view name);

}  // namespace headframe
