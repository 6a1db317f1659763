#include "common/wire/lossy_link.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace headframe {

void expect_losses(int socket) {
  constexpr int rto_max_ms_option = 44;  // TCP_RTO_MAX_MS: newer than Debian 12's headers
  const int on = 1, most_wait_ms = 1000, alive_ms = 90000;
  (void)::setsockopt(socket, IPPROTO_TCP, TCP_THIN_LINEAR_TIMEOUTS, &on, sizeof on);
  (void)::setsockopt(socket, IPPROTO_TCP, rto_max_ms_option, &most_wait_ms, sizeof most_wait_ms);
  (void)::setsockopt(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, &alive_ms, sizeof alive_ms);
}

}  // namespace headframe
