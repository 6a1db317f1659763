#include "client/uplink/kernel_queue.hpp"

#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>

namespace headframe {

std::size_t kernel_room(int socket, std::size_t most) {
  constexpr double waits_s = 0.5, behind_chunk_s = 0.05, us = 1e-6;
  constexpr double least_held = 1400;  // so that a link of unknown speed can show what it delivers
  constexpr std::size_t least_chunk = 512;
  tcp_info info{};
  socklen_t size = sizeof info;
  int held = 0;
  if (::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0 || ::ioctl(socket, SIOCOUTQ, &held) != 0)
    return most;
  const auto rate = static_cast<double>(info.tcpi_delivery_rate);
  const double may_hold = std::max(least_held, rate * (info.tcpi_min_rtt * us + waits_s));
  if (held > may_hold) return 0;
  return std::clamp(static_cast<std::size_t>(rate * behind_chunk_s), std::min(least_chunk, most), most);
}

bool loses_packets(int socket, double share) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return false;
  return info.tcpi_total_retrans > 2 && info.tcpi_total_retrans > share * info.tcpi_segs_out;
}

}  // namespace headframe
