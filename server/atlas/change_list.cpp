#include "server/atlas/change_list.hpp"

#include <algorithm>

namespace headframe {
namespace {

constexpr double slack_m = 2;  // sessions lie some decimetres off and see a change from two sides

bool same(const PlacedChange& one, const PlacedChange& other) {
  const double reach_m = slack_m + std::max(one.change.length_m, other.change.length_m) / 2;
  return one.component == other.component && one.component != 0 && one.change.kind == other.change.kind &&
         one.change.older_s < other.change.newer_s && other.change.older_s < one.change.newer_s &&
         (one.p - other.p).norm() < reach_m;
}

/// Combines two sightings: it came after the later of the older sessions and before the earlier of the newer ones.
void narrow_down(PlacedChange& known, const PlacedChange& more) {
  if (more.change.older_s > known.change.older_s) {
    known.change.older_s = more.change.older_s;
    known.older = more.older;
    known.alignment = more.alignment;
  }
  if (more.change.newer_s < known.change.newer_s) {
    known.change.newer_s = more.change.newer_s;
    known.newer = more.newer;
    known.alignment = more.alignment;
  }
  known.change.length_m = std::max(known.change.length_m, more.change.length_m);
  known.change.width_m = std::max(known.change.width_m, more.change.width_m);
  known.change.height_m = std::max(known.change.height_m, more.change.height_m);
}

}  // namespace

std::vector<PlacedChange> changes_of(const Alignment& alignment, const Atlas& atlas) {
  std::vector<PlacedChange> out;
  for (const Change& change : alignment.changes) {
    const auto [older, newer] =
        change.a_is_newer ? std::pair(alignment.b, alignment.a) : std::pair(alignment.a, alignment.b);
    const Eigen::Vector3d p_older = change.a_is_newer ? alignment.T_a_b.inverse() * change.p_a : change.p_a;
    PlacedChange placed{alignment.id, 0, p_older, older, newer, change};
    for (const Component& component : atlas.components)
      if (const Placement* of_older = placement_in(component, older); of_older && placement_in(component, newer)) {
        placed.component = component.id;
        placed.p = of_older->T_component_session * p_older;
      }
    out.push_back(placed);
  }
  return out;
}

std::vector<PlacedChange> changes_since(double since_s, const std::vector<const Alignment*>& alignments,
                                        const Atlas& atlas) {
  std::vector<PlacedChange> out;
  for (const Alignment* alignment : alignments) {
    if (alignment->state != AlignmentState::published) continue;
    for (const PlacedChange& change : changes_of(*alignment, atlas)) {
      const auto known = std::find_if(out.begin(), out.end(), [&](const auto& other) { return same(other, change); });
      if (known == out.end())
        out.push_back(change);
      else
        narrow_down(*known, change);
    }
  }
  std::erase_if(out, [&](const PlacedChange& c) { return c.change.newer_s < since_s; });
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& c, const auto& d) { return c.change.newer_s > d.change.newer_s; });
  return out;
}

}  // namespace headframe
