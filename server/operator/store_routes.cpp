// How much space is free, and which clouds can be deleted to make more.
#include <map>
#include <nlohmann/json.hpp>

#include "server/operator/routes.hpp"

namespace headframe::routes {
namespace {

using Json = nlohmann::json;

Json json_of(const std::vector<CoveredClouds>& covered, const Station& station) {
  std::map<SessionId, SessionKey> keys;
  for (const SessionRow& row : station.sessions()) keys[row.id] = row.key;
  Json sessions = Json::array();
  std::uint64_t clouds = 0, bytes = 0;
  for (const CoveredClouds& of : covered) {
    clouds += of.clouds.size();
    bytes += of.bytes;
    sessions.push_back({{"id", of.session},
                        {"robot", keys[of.session].robot},
                        {"session", keys[of.session].session},
                        {"clouds", of.clouds.size()},
                        {"stored", of.stored},
                        {"bytes", of.bytes}});
  }
  return {{"clouds", clouds}, {"bytes", bytes}, {"sessions", std::move(sessions)}};
}

}  // namespace

Result<Reply> store(const Query&, const Context& context) {
  const auto look = [&station = context.station](const std::function<void(Ready)>& answer) {
    const auto free_bytes = station.free_bytes();
    if (!free_bytes) return answer(error_reply(free_bytes.error()));
    const auto covered = station.covered_clouds();
    if (!covered) return answer(error_reply(covered.error()));
    std::uint64_t let_go = 0;
    for (const SessionRow& row : station.sessions()) let_go += row.let_go;
    const KeepPolicy policy = station.keep_policy();
    answer(json(Json{{"keep", policy.newest ? "newest" : "all"},
                     {"least_free_bytes", policy.newest ? Json(policy.free_bytes) : Json()},
                     {"free_bytes", *free_bytes ? Json(**free_bytes) : Json()},
                     {"let_go", let_go},
                     {"may_go", json_of(*covered, station)}}
                    .dump() +
                "\n"));
  };
  return Later{look, true};
}

/// Determines again which clouds may be deleted, because this may have changed since the operator saw the list.
Result<Reply> let_go(const Query& query, const Context& context) {
  constexpr double most = 1e18;
  const auto bytes = whole_number(query, "bytes", most, most);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto act = [&station = context.station, bytes = *bytes](const std::function<void(Ready)>& answer) {
    const auto covered = station.covered_clouds();
    if (!covered) return answer(error_reply(covered.error()));
    const std::vector<CoveredClouds> goes = first_bytes(*covered, bytes);
    station.let_go(goes, [&station, goes, answer](const Result<void>& done) {
      answer(done ? json(json_of(goes, station).dump() + "\n") : error_reply(done.error()));
    });
  };
  return Later{act, true};
}

}  // namespace headframe::routes
