// What may be done at the operator's port without the token.

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <memory>

#include "tests/support/hostile_peers.hpp"

namespace headframe::test {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

class Client {
 public:
  explicit Client(const HostileTarget& target) {
    error_code full;
    socket_.connect({asio::ip::make_address(target.http.host), target.http.port}, full);
  }
  void send(const std::string& bytes) {
    error_code closed;
    asio::write(socket_, asio::buffer(bytes), closed);
  }
  void until_closed() {
    std::string rest;
    error_code end;
    asio::read(socket_, asio::dynamic_buffer(rest, 1 << 20), end);
  }

 private:
  asio::io_context io_;
  tcp::socket socket_{io_};
};

const std::string head = "GET /api/v1/status HTTP/1.1\r\nHost: a\r\nConnection: close\r\n";

void half_open(const HostileTarget& target) {
  std::vector<std::unique_ptr<Client>> clients;
  for (int i = 0; i < 100; ++i) {
    clients.push_back(std::make_unique<Client>(target));
    clients.back()->send("GET / HTTP/1.1\r\nHost: a\r\n");
  }
}

void two_meanings(const HostileTarget& target) {
  for (const char* fields : {"Transfer-Encoding: gzip\r\n", "X: y\r\n z\r\n", "Host: b\r\n",
                             "Transfer-Encoding: chunked\r\nContent-Length: 3\r\n"}) {
    Client client(target);
    client.send(head + fields + "\r\n");
    client.until_closed();
  }
}

void wrong_operator_tokens(const HostileTarget& target) {
  for (int i = 0; i < 30; ++i) {
    Client client(target);
    client.send(head + "Authorization: Bearer " + std::string(64, '0') + "\r\n\r\n");
    client.until_closed();
  }
}

void request_flood(const HostileTarget& target) {
  std::string all;
  for (int i = 0; i < 200; ++i) all += "GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n";
  Client client(target);
  client.send(all + head + "\r\n");
  client.until_closed();
}

void endless_header(const HostileTarget& target) {
  Client client(target);
  client.send(head);
  for (int i = 0; i < 2000; ++i) client.send("X-" + std::to_string(i) + ": y\r\n");
  client.until_closed();
}

}  // namespace

const std::vector<HostileAct>& hostile_clients() {
  static const std::vector<HostileAct> acts{
      {"half-open requests", half_open},
      {"requests of two meanings", two_meanings},
      {"wrong operator tokens", wrong_operator_tokens},
      {"request flood", request_flood},
      {"endless header", endless_header},
  };
  return acts;
}

}  // namespace headframe::test
