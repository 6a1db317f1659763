#pragma once
// ./run bench rejudge ROWS.csv...: what a changed verdict would do to placements that were judged before.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace headframe::bench {

/// Judges the placements in files that stages, merges, recordings and drawn-mines wrote (verdict*.csv) anew, from their
/// evidence, with the verdict of this build. Prints each that is accepted now and was not, or the other way round; how
/// many right and wrong ones are accepted, by kind of mine; and for each contribution to the log-odds how many more
/// would be accepted if it never spoke against a placement, and at how many right ones that wait it speaks loudest.
/// Evidence that depends on the verdict (aliases, runner_up) stays as it was recorded. Throws if a file is none of
/// these, or is damaged. Writes all of them to `rejudged`, as such a file, with what this build makes of them: the fits
/// take such rows.
nlohmann::json rejudge(const std::vector<std::filesystem::path>& files, const std::filesystem::path& rejudged);

}  // namespace headframe::bench
