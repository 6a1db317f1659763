#include "server/security/relayed_peer.hpp"

#include <sys/socket.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <memory>

#include "server/security/relay_header.hpp"

namespace headframe {
namespace {

namespace net = boost::asio;
using boost::system::error_code;

constexpr auto whole_within = std::chrono::seconds(2);  // a relay sends it in one piece

class HeaderRead : public std::enable_shared_from_this<HeaderRead> {
 public:
  using Done = std::function<void(const Result<net::ip::address>&)>;

  HeaderRead(net::ip::tcp::socket& socket, std::string key, Done done)
      : socket_(socket), timer_(socket.get_executor()), key_(std::move(key)), done_(std::move(done)) {}

  void start() {
    timer_.expires_after(whole_within);
    timer_.async_wait([self = shared_from_this()](error_code) {
      if (!self->done_) return;  // the socket may be gone
      error_code ignored;
      self->socket_.cancel(ignored);
    });
    read(relay_preamble_bytes, [](HeaderRead& self) {
      const auto left = relay_bytes_left(self.header_);
      if (!left) return self.finish(tl::unexpected(left.error()));
      self.read(*left, [](HeaderRead& whole) { whole.finish(relayed_client(whole.header_, whole.key_)); });
    });
  }

 private:
  template <class Next>
  void read(std::size_t bytes, Next next) {
    const std::size_t known = header_.size();
    header_.resize(known + bytes);
    net::async_read(socket_, net::buffer(header_.data() + known, bytes),
                    [self = shared_from_this(), next](error_code error, std::size_t) {
                      if (!error) return next(*self);
                      self->finish(failure(ErrorCode::unavailable, "no header of a relay: " + error.message()));
                    });
  }

  void finish(const Result<net::ip::address>& result) {
    timer_.cancel();
    std::exchange(done_, nullptr)(result);
  }

  net::ip::tcp::socket& socket_;
  net::steady_timer timer_;
  const std::string key_;
  Done done_;
  std::string header_;
};

}  // namespace

/// A wait may end though no byte is there yet. Taken for an answer, that would mistake a relay for a client that speaks
/// in the clear.
void async_first_byte(net::ip::tcp::socket& socket, std::function<void(std::optional<unsigned char>)> done) {
  socket.async_wait(net::ip::tcp::socket::wait_read, [&socket, done = std::move(done)](error_code error) mutable {
    unsigned char first = 0;
    const auto seen = error ? 0 : ::recv(socket.native_handle(), &first, 1, MSG_PEEK | MSG_DONTWAIT);
    if (seen < 0 && (errno == EAGAIN || errno == EINTR)) return async_first_byte(socket, std::move(done));
    done(seen == 1 ? std::optional(first) : std::nullopt);
  });
}

void async_read_relay_header(net::ip::tcp::socket& socket, std::string key,
                             std::function<void(const Result<net::ip::address>&)> done) {
  std::make_shared<HeaderRead>(socket, std::move(key), std::move(done))->start();
}

}  // namespace headframe
