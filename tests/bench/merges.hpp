#pragma once
// ./run bench merges: can merges be trusted, and how long do they take?

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/bench/pipeline_run.hpp"
#include "tests/mine/plan.hpp"

namespace headframe::bench {

struct Campaign {
  int mines = 56;
  Clouds clouds = Clouds::at_once;
  std::filesystem::path out;         // pictures, and the evidence of all that was judged
  std::uint64_t first_seed = 90000;  // of the first mine: from here on none was used to set a weight
  std::vector<mine::Kind> kinds{mine::Kind::junctions, mine::Kind::grid,     mine::Kind::room_and_pillar,
                                mine::Kind::ramp,      mine::Kind::straight, mine::Kind::look_alike};
};

/// Pairs of sessions in simulated mines: what was merged, what should have been, how far off, and how many clouds were
/// sent; a table by kind and by overlap. Draws what was missed, wrong or 0.4 m off.
nlohmann::json run_campaign(const Campaign& campaign);

/// All pairs of the recordings, within and across their sets, with the evidence: as they are, with every frame turned,
/// and with 5 % of the keyframes noise besides. Null, and a line that says so, where there are none.
nlohmann::json recordings_crossed(const std::filesystem::path& recordings, const std::filesystem::path& out_folder);

/// From the trigger to the published transform, by stage; two sessions of 300 keyframes, then with others in the
/// database.
nlohmann::json merge_times();

}  // namespace headframe::bench
