#include "server/net/bind_port.hpp"

namespace headframe {

boost::system::error_code bind_port(boost::asio::ip::tcp::acceptor& acceptor, const Endpoint& at) {
  using boost::asio::ip::tcp;
  boost::system::error_code error;
  tcp::resolver resolver(acceptor.get_executor());
  const auto found = resolver.resolve(at.host, std::to_string(at.port),
                                      tcp::resolver::passive | tcp::resolver::numeric_service, error);
  if (error) return error;
  const tcp::endpoint endpoint = *found.begin();
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  return error;
}

tl::unexpected<Error> listen_failure(const Endpoint& at, const boost::system::error_code& why) {
  std::string to_do;
  if (why == boost::asio::error::address_in_use)
    to_do = "; is a server running already? End the program that uses the port, or choose another one";
  if (why == boost::system::errc::address_not_available) to_do = "; give an address of this machine";
  return failure(ErrorCode::unavailable, "cannot listen on " + to_string(at) + ": " + why.message() + to_do);
}

}  // namespace headframe
