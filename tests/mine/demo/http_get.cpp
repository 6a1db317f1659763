#include "tests/mine/demo/http_get.hpp"

#include <boost/asio/ip/tcp.hpp>
#include <iterator>

namespace headframe::demo {

Result<nlohmann::json> http_get(const std::string& address, const std::string& target, std::chrono::seconds timeout) {
  const auto colon = address.rfind(':');
  if (colon == std::string::npos) return failure(ErrorCode::invalid_argument, "'" + address + "' is not HOST:PORT");
  boost::asio::ip::tcp::iostream stream;
  stream.expires_after(timeout);
  stream.connect(address.substr(0, colon), address.substr(colon + 1));
  // HTTP 1.0: the answer ends where the connection does.
  stream << "GET " << target << " HTTP/1.0\r\nHost: " << address << "\r\n\r\n" << std::flush;
  std::string version, line;
  int status = 0;
  stream >> version >> status;
  while (std::getline(stream, line) && line != "\r") continue;
  const std::string body(std::istreambuf_iterator<char>(stream), {});
  if (status == 0) return failure(ErrorCode::unavailable, "no answer from http://" + address + target);
  nlohmann::json json = nlohmann::json::parse(body, nullptr, false);
  if (status != 200 || json.is_discarded())
    return failure(ErrorCode::bad_input, "http://" + address + target + " answered " + std::to_string(status));
  return json;
}

}  // namespace headframe::demo
