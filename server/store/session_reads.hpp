#pragma once
// What is read of single sessions, through any connection.

#include <functional>
#include <optional>
#include <vector>

#include "common/session/keyframe.hpp"
#include "server/session/ids.hpp"
#include "server/store/database.hpp"

namespace headframe {

/// Store::each_keyframe. `damaged` is called for each row that is not what was written.
Result<void> read_keyframes(Database& database, SessionId session, std::uint64_t first,
                            const std::function<void(Keyframe)>& visit,
                            const std::function<void(std::uint64_t sequence)>& damaged);

/// Store::cloud_sequences.
Result<std::vector<std::uint64_t>> read_cloud_sequences(Database& database, SessionId session);

/// As the robot sent it; not_found: there is none.
Result<std::string> read_cloud(Database& database, const KeyframeRef& keyframe);

/// Of its descriptors; nullopt: there is no such session.
Result<std::optional<FamilyId>> read_family(Database& database, SessionId session);

}  // namespace headframe
