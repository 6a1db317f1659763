#pragma once

#include <fstream>

#include "server/operator/body_source.hpp"
#include "server/station/station.hpp"

namespace headframe {

/// A backup of the whole base station, as one file. It is made on the server's disk with the first call of next(), and
/// has no name there from then on, so that nothing is left of it however this ends.
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
