#include "tests/bench/link/bad_link.hpp"
#include "tests/bench/link/seconds_since.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <random>
#include <thread>

namespace headframe::bench {
namespace {

Clock::duration seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

/// A namespace: the thread that opened it is gone, these keep it.
struct Side {
  int tun = -1;
  int space = -1;
  ~Side() {
    if (tun >= 0) ::close(tun);
    if (space >= 0) ::close(space);
  }
};

bool up(const char* device, const char* address) {
  const int control = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strncpy(request.ifr_name, device, IFNAMSIZ - 1);
  auto* in = reinterpret_cast<sockaddr_in*>(&request.ifr_addr);
  in->sin_family = AF_INET;
  ::inet_pton(AF_INET, address, &in->sin_addr);
  bool done = ::ioctl(control, SIOCSIFADDR, &request) == 0;
  ::inet_pton(AF_INET, "255.255.255.0", &in->sin_addr);
  done = done && ::ioctl(control, SIOCSIFNETMASK, &request) == 0 && ::ioctl(control, SIOCGIFFLAGS, &request) == 0;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
  done = done && ::ioctl(control, SIOCSIFFLAGS, &request) == 0;
  ::close(control);
  return done;
}

/// Makes a namespace with a TUN device of this address; false: not allowed here.
bool enter(Side& side, const char* address) {
  if (::unshare(CLONE_NEWNET) != 0) return false;
  side.space = ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
  side.tun = ::open("/dev/net/tun", O_RDWR | O_CLOEXEC | O_NONBLOCK);
  ifreq request{};
  std::strncpy(request.ifr_name, "radio", IFNAMSIZ - 1);
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  return side.space >= 0 && side.tun >= 0 && ::ioctl(side.tun, TUNSETIFF, &request) == 0 && up("radio", address) &&
         up("lo", "127.0.0.1");
}

}  // namespace

struct BadLink::Radio {
  explicit Radio(std::uint32_t seed) : random(seed) {}

  std::array<Side, 2> sides;  // robots, server
  std::mutex mutex;
  RadioConditions conditions;
  Clock::time_point began = Clock::now();
  std::mt19937 random;
  std::array<Clock::time_point, 2> free{};  // when each direction has sent what it took
  std::multimap<Clock::time_point, std::pair<std::size_t, std::string>> flying;
  std::atomic<std::uint64_t> arrived{0};
  std::atomic<bool> stopping{false};
  std::thread thread;

  bool dark(Clock::time_point now) const {
    if (conditions.blackout_s <= 0) return false;
    const double into = std::fmod(std::chrono::duration<double>(now - began).count(), conditions.period_s);
    return into >= conditions.period_s - conditions.blackout_s;
  }

  void take(std::size_t from, std::string packet) {
    const std::lock_guard lock(mutex);
    const auto now = Clock::now();
    std::uniform_real_distribution<double> part(0, 1);
    if (dark(now) || part(random) < conditions.loss) return;
    auto at = now;
    if (conditions.bytes_per_s > 0) {
      const auto turn = std::max(now, free[from]);
      if (turn - now > seconds(conditions.queue_s)) return;
      at = free[from] = turn + seconds(static_cast<double>(packet.size()) / conditions.bytes_per_s);
    }
    if (from == 0) at += seconds(conditions.delay_s + conditions.jitter_s * (2 * part(random) - 1));
    flying.emplace(at, std::make_pair(1 - from, std::move(packet)));
  }

  /// Delivers what is due; says in how many milliseconds the next one is.
  int deliver() {
    const std::lock_guard lock(mutex);
    const auto now = Clock::now();
    for (; !flying.empty() && flying.begin()->first <= now; flying.erase(flying.begin())) {
      const auto& [to, packet] = flying.begin()->second;
      if (dark(now) || ::write(sides[to].tun, packet.data(), packet.size()) < 0) continue;
      if (to == 1) arrived += packet.size();
    }
    if (flying.empty()) return 50;
    const auto wait = std::chrono::ceil<std::chrono::milliseconds>(flying.begin()->first - now).count();
    return static_cast<int>(std::min<std::int64_t>(wait, 50));
  }

  void run() {
    std::array<char, 4096> packet;
    while (!stopping) {
      std::array<pollfd, 2> ready{pollfd{sides[0].tun, POLLIN, 0}, pollfd{sides[1].tun, POLLIN, 0}};
      ::poll(ready.data(), ready.size(), deliver());
      for (std::size_t from = 0; from < sides.size(); ++from)
        for (ssize_t n = 0; (n = ::read(sides[from].tun, packet.data(), packet.size())) > 0;)
          take(from, std::string(packet.data(), static_cast<std::size_t>(n)));
    }
  }

  void in(std::size_t side, const std::function<void()>& work) const {
    std::thread([&] {
      if (::setns(sides[side].space, CLONE_NEWNET) == 0) work();
    }).join();
  }
};

Result<std::unique_ptr<BadLink>> BadLink::make(std::uint32_t seed) {
  auto radio = std::make_unique<Radio>(seed);
  bool made = false;
  std::thread([&] { made = enter(radio->sides[0], "10.77.0.2") && enter(radio->sides[1], server_address); }).join();
  if (!made)
    return failure(ErrorCode::unavailable, "network namespaces with TUN devices can not be made here (" +
                                               std::string(std::strerror(errno)) +
                                               "): run as root where /dev/net/tun is");
  radio->thread = std::thread([r = radio.get()] { r->run(); });
  return std::unique_ptr<BadLink>(new BadLink(std::move(radio)));
}

BadLink::BadLink(std::unique_ptr<Radio> radio) : radio_(std::move(radio)) {}

BadLink::~BadLink() {
  radio_->stopping = true;
  radio_->thread.join();
}

void BadLink::set(const RadioConditions& conditions) {
  const std::lock_guard lock(radio_->mutex);
  radio_->conditions = conditions;
  radio_->began = Clock::now();
  radio_->free = {};
}

void BadLink::as_robot(const std::function<void()>& work) { radio_->in(0, work); }
void BadLink::as_server(const std::function<void()>& work) { radio_->in(1, work); }
std::uint64_t BadLink::bytes_to_server() const { return radio_->arrived; }

}  // namespace headframe::bench
