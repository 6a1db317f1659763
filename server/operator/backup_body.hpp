#pragma once

#include <fstream>

#include "server/operator/body_source.hpp"
#include "server/station/station.hpp"

namespace headframe {

/// A backup of the whole base station as one file. The first call of next() makes it on the server's disk and then
/// unlinks it, so nothing of it remains, whether or not sending succeeds.
class BackupBody : public BodySource {
 public:
  explicit BackupBody(Station& station) : station_(station) {}
  Result<std::optional<std::string>> next() override;
  std::optional<std::uint64_t> total_bytes() const override { return bytes_; }

 private:
  Result<void> make();

  Station& station_;
  std::ifstream file_;
  std::optional<std::uint64_t> bytes_;
  std::uint64_t sent_ = 0;
};

}  // namespace headframe
