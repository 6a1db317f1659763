#include "tests/bench/servers/revision_book.hpp"

namespace headframe::bench {

void RevisionBook::look(std::uint64_t revision, const std::string& content) {
  const auto [known, is_new] = content_.emplace(revision, content);
  const bool went_back = revision < content_.rbegin()->first;
  seen_.revisions += is_new ? 1 : 0;
  if (known->second == content && !went_back) return;
  ++seen_.contradictions;
  if (seen_.first.empty())
    seen_.first =
        "revision " + std::to_string(revision) +
        (went_back ? " after " + std::to_string(content_.rbegin()->first) : ": " + known->second + " and " + content);
}

}  // namespace headframe::bench
