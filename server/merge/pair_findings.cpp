#include "server/merge/pair_findings.hpp"

#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "common/security/secret.hpp"

namespace headframe {
namespace {

constexpr std::size_t digest_bytes = 32;
constexpr std::size_t most_of_a_list = 1 << 20;

class Writer {
 public:
  template <class Number>
  void number(const Number& value) {
    static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class Matrix>
  void matrix(const Matrix& m) {
    bytes_.append(reinterpret_cast<const char*>(m.data()), static_cast<std::size_t>(m.size()) * sizeof *m.data());
  }
  template <class List, class Each>
  void list(const List& items, const Each& each) {
    number(static_cast<std::uint64_t>(items.size()));
    for (const auto& item : items) each(item);
  }
  std::string sealed() && {
    bytes_ += sha256(bytes_);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

/// Throws where the bytes end too early.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  template <class Number>
  void number(Number& value) {
    copy(&value, sizeof value);
  }
  template <class Matrix>
  void matrix(Matrix& m) {
    copy(m.data(), static_cast<std::size_t>(m.size()) * sizeof *m.data());
  }
  template <class List, class Each>
  void list(List& items, const Each& each) {
    std::uint64_t count = 0;
    number(count);
    if (count > most_of_a_list) throw std::length_error("a list is too long");
    for (std::uint64_t i = 0; i < count; ++i) each(items.emplace_back());
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  void copy(void* to, std::size_t count) {
    if (bytes_.size() < count) throw std::length_error("it ends too early");
    std::memcpy(to, bytes_.data(), count);
    bytes_.remove_prefix(count);
  }
  std::string_view bytes_;
};

/// The members in their order, for writing and reading alike.
template <class Stream, class OfRegistration>
void registration(Stream& stream, OfRegistration& r) {
  stream.matrix(r.T_target_source.matrix());
  stream.number(r.status);
  stream.number(r.iterations);
  for (auto* value : {&r.inlier_fraction, &r.rmse_m, &r.residuals.median_m, &r.residuals.p90_m, &r.residuals.p99_m})
    stream.number(*value);
  stream.matrix(r.information);
  for (auto* vector : {&r.centre, &r.direction_hold, &r.weakest_direction}) stream.matrix(*vector);
  stream.list(r.free_directions, [&](auto& direction) {
    stream.number(direction.kind);
    stream.matrix(direction.axis);
    stream.number(direction.hold);
  });
}

template <class Stream, class OfCheck>
void check(Stream& stream, OfCheck& c) {
  stream.matrix(c.p_a);
  stream.matrix(c.p_b);
  registration(stream, c.registration);
  for (auto* value : {&c.residual_m, &c.matched.on, &c.matched.comparable}) stream.number(*value);
  for (auto* side : {&c.a_by_b, &c.b_by_a})
    for (auto* value : {&side->seen, &side->violated, &side->lone, &side->unknown}) stream.number(*value);
  stream.list(c.changes, [&](auto& patch) {
    stream.list(patch.points, [&](auto& point) { stream.matrix(point); });
    stream.number(patch.kind);
    stream.number(patch.free_standing);
    stream.number(patch.dates.a_is_newer);
    stream.number(patch.dates.older_s);
    stream.number(patch.dates.newer_s);
  });
}

template <class Stream, class OfJudgement>
void judgement(Stream& stream, OfJudgement& j) {
  stream.number(j.status);
  stream.matrix(j.T_a_b.matrix());
  for (const EvidenceField& field : evidence_fields()) stream.number(j.evidence.*field.member);
  stream.list(j.changes, [&](auto& change) {
    stream.number(change.kind);
    stream.matrix(change.p_a);
    for (auto* value : {&change.length_m, &change.width_m, &change.height_m, &change.older_s, &change.newer_s})
      stream.number(*value);
    stream.number(change.a_is_newer);
  });
}

template <class Stream, class OfFindings>
void all(Stream& stream, OfFindings& f) {
  stream.list(f.hypotheses, [&](auto& h) {
    stream.matrix(h.T_a_b.matrix());
    stream.number(h.score);
    stream.matrix(h.place_b);
    stream.number(h.descriptors.sum);
    stream.number(h.descriptors.count);
    stream.number(h.promise);
    stream.number(h.contradiction);
    stream.number(h.source);
  });
  stream.list(f.hopeful, [&](auto& one) {
    stream.number(one.hypothesis);
    check(stream, one.place);
  });
  stream.list(f.judged, [&](auto& one) {
    stream.number(one.hypothesis);
    judgement(stream, one.judgement);
  });
  stream.number(f.itself.path_m);
  stream.number(f.itself.clouds);
  stream.number(f.itself.aliases);
  stream.number(f.itself.look_alikes);
  stream.number(f.itself.similar_places);
  stream.list(f.itself.places, [&](auto& place) {
    stream.matrix(place.here);
    stream.matrix(place.there);
    stream.number(place.placement);
    stream.number(place.likeness);
    stream.number(place.resemblance);
    stream.number(place.copy);
  });
}

}  // namespace

std::string encode_findings(const PairFindings& findings) {
  Writer writer;
  all(writer, findings);
  return std::move(writer).sealed();
}

Result<PairFindings> decode_findings(std::string_view bytes) {
  const auto damaged = [] { return failure(ErrorCode::bad_input, "what was found of a pair of sessions is damaged"); };
  if (bytes.size() < digest_bytes) return damaged();
  const std::string_view content = bytes.substr(0, bytes.size() - digest_bytes);
  if (sha256(content) != bytes.substr(content.size())) return damaged();
  PairFindings findings;
  try {
    Reader reader(content);
    all(reader, findings);
    if (!reader.at_end()) return damaged();
  } catch (const std::length_error&) {
    return damaged();
  }
  for (const HopefulCase& one : findings.hopeful)
    if (one.hypothesis >= findings.hypotheses.size()) return damaged();
  return findings;
}

}  // namespace headframe
