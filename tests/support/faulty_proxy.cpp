#include "tests/support/faulty_proxy.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <limits>
#include <random>
#include <thread>
#include <vector>

namespace headframe::test {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t for_good = std::numeric_limits<std::size_t>::max();

struct Pair {
  explicit Pair(boost::asio::io_context& io)
      : ends{tcp::socket(io), tcp::socket(io)}, paces{boost::asio::steady_timer(io), boost::asio::steady_timer(io)} {}
  std::array<tcp::socket, 2> ends;                 // robot, server
  std::array<boost::asio::steady_timer, 2> paces;  // for what comes from that end
  std::array<std::array<char, 1500>, 2> bytes{};
  std::size_t left = for_good;
  bool stalls = false;
  int number = 0;

  void close() {
    error_code ignored;
    for (auto& end : ends) end.close(ignored);
  }
};

}  // namespace

struct FaultyProxy::State {
  State(std::uint16_t port, const LinkFaults& f)
      : to(boost::asio::ip::make_address("127.0.0.1"), port), plan(f), random(f.seed) {}

  std::size_t pick(std::size_t most) { return std::uniform_int_distribution<std::size_t>(1, most)(random); }

  void accept() {
    auto pair = std::make_shared<Pair>(io);
    acceptor.async_accept(pair->ends[0], [this, pair](error_code error) {
      if (error) return;
      pair->ends[1].connect(to, error);
      if (error) {
        pair->close();
      } else {
        if (begun < plan.cuts + plan.stalls) pair->left = pick(plan.most_bytes);
        pair->stalls = begun >= plan.cuts;
        pair->number = begun++;
        forward(pair, 0);
        forward(pair, 1);
      }
      accept();
    });
  }

  void forward(const std::shared_ptr<Pair>& pair, std::size_t from) {
    auto& bytes = pair->bytes[from];
    pair->ends[from].async_read_some(
        boost::asio::buffer(bytes, pick(bytes.size())), [this, pair, from](error_code error, std::size_t n) {
          if (error) return pair->close();
          if (pair->number == stalled) return silent.push_back(pair);
          const std::size_t passed = std::min(n, pair->left);  // a frame is cut anywhere
          if (pair->left != for_good) pair->left -= passed;
          if (from == 0) to_server += passed;
          boost::asio::write(pair->ends[1 - from], boost::asio::buffer(pair->bytes[from], passed), error);
          if (error) return pair->close();
          if (pair->left > 0) return forward_in_time(pair, from, passed);
          ++happened;
          if (pair->stalls)
            silent.push_back(pair);  // both ends stay open
          else
            pair->close();
        });
  }

  /// The next bytes once those that were passed on have taken their time.
  void forward_in_time(const std::shared_ptr<Pair>& pair, std::size_t from, std::size_t passed) {
    if (plan.bytes_per_s <= 0) return forward(pair, from);
    const std::chrono::duration<double> taken(static_cast<double>(passed) / plan.bytes_per_s);
    pair->paces[from].expires_after(std::chrono::duration_cast<std::chrono::steady_clock::duration>(taken));
    pair->paces[from].async_wait([this, pair, from](error_code error) {
      if (!error) forward(pair, from);
    });
  }

  boost::asio::io_context io{1};
  tcp::acceptor acceptor{io, {boost::asio::ip::make_address("127.0.0.1"), 0}};
  const tcp::endpoint to;
  const LinkFaults plan;
  std::mt19937 random;
  std::atomic<int> begun{0}, stalled{-1};
  std::atomic<int> happened{0};
  std::atomic<std::uint64_t> to_server{0};
  std::vector<std::shared_ptr<Pair>> silent;
  std::thread thread;
};

FaultyProxy::FaultyProxy(std::uint16_t port, const LinkFaults& faults) : state_(std::make_unique<State>(port, faults)) {
  state_->accept();
  state_->thread = std::thread([s = state_.get()] { s->io.run(); });
}

FaultyProxy::~FaultyProxy() {
  state_->io.stop();
  state_->thread.join();
}

std::uint16_t FaultyProxy::port() const { return state_->acceptor.local_endpoint().port(); }
int FaultyProxy::faults() const { return state_->happened; }
int FaultyProxy::connections() const { return state_->begun; }
void FaultyProxy::stall(int connection) { state_->stalled = connection; }
std::uint64_t FaultyProxy::bytes_to_server() const { return state_->to_server; }

}  // namespace headframe::test
