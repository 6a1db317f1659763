#include "client/uplink/server_list.hpp"

#include <utility>

namespace headframe {

std::size_t ServerList::take() { return std::exchange(next_, after(next_)); }

void ServerList::found(std::size_t server) {
  next_ = server;
  failures_ = 0;
  backoff_.reset();
}

double ServerList::failed(std::size_t server) {
  if (next_ == server) next_ = after(server);
  if (++failures_ < servers_.size()) return 0;
  failures_ = 0;
  return backoff_.next_s();
}

}  // namespace headframe
