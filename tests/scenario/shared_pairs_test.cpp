// Attempts whose searches other servers share: whatever those do, the result is the same to the bit.

#include <gtest/gtest.h>

#include <functional>

#include "tests/support/pair_searcher.hpp"

namespace headframe {
namespace {

using test::Base;
using test::Drive;
using test::PairSearcher;

std::vector<Drive> drives() { return {test::drive_a_to_c(3), test::drive_b_to_a(3), test::drive_d_to_b(3)}; }

class OtherServer : public PairHelpers {
 public:
  std::function<Answer(const PairTask&)> asked = [](const PairTask&) { return Answer(); };
  std::function<Answer(const PairTask&)> waited = [](const PairTask&) { return Answer(); };
  bool gives_claims = false;
  int comes_after = 0;  // so many questions whether anybody is there

  bool any() override { return comes_after-- <= 0; }
  void announce(const std::vector<PairTask>& tasks) override {
    for (const PairTask& task : tasks) open[task.digest] = task;
    for (const PairTask& task : tasks) ever.insert(task.digest);
    announced += tasks.size();
  }
  Answer ask(const PairTask& task) override {
    EXPECT_TRUE(ever.contains(task.digest)) << "only what was announced is asked for";
    open.erase(task.digest);
    ++asks;
    return asked(task);
  }
  std::optional<PairTask> claim() override {
    if (!gives_claims || open.empty()) return std::nullopt;
    const PairTask task = open.begin()->second;
    open.erase(open.begin());
    ++claims;
    return task;
  }
  Answer wait(const PairTask& task) override {
    ++waits;
    return waited(task);
  }
  void withdraw(const std::vector<PairTask>& tasks) override {
    for (const PairTask& task : tasks) open.erase(task.digest);
  }

  std::map<std::string, PairTask> open;
  std::set<std::string> ever;
  std::size_t announced = 0;
  int asks = 0, claims = 0, waits = 0;
};

/// All numbers of all alignments, as bytes.
std::string bytes_of(const MergePipeline& pipeline) {
  std::string out;
  const auto add = [&](const auto& value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const Alignment& k : pipeline.alignments()) {
    add(k.a);
    add(k.b);
    add(k.state);
    out.append(reinterpret_cast<const char*>(k.T_a_b.matrix().data()), 16 * sizeof(double));
    for (const EvidenceField& field : evidence_fields()) add(k.evidence.*field.member);
  }
  for (const Component& component : pipeline.atlas().components)
    for (const Placement& p : component.placements)
      out.append(reinterpret_cast<const char*>(p.T_component_session.matrix().data()), 16 * sizeof(double));
  return out;
}

std::string merged(PairHelpers* helpers) {
  Base base(drives(), test::waits_for_no_others(), helpers);
  for (const SessionId id : {1, 2, 3}) base.pipeline.attempt(id, base.shelf);
  EXPECT_EQ(base.pipeline.atlas().components.size(), 1U);
  return bytes_of(base.pipeline);
}

class SharedPairs : public testing::Test {
 protected:
  PairHelpers::Answer right(const PairTask& task) {
    EXPECT_EQ(task.digest, there.digest(task.a, task.b)) << "both know the same data by the same digest";
    return {PairHelpers::Turn::done, there.find(task.a, task.b)};
  }

  const std::string alone = merged(nullptr);
  PairSearcher there{drives()};
  OtherServer other;
};

TEST_F(SharedPairs, WhatAnotherServerFoundIsTaken) {
  other.asked = [&](const PairTask& task) { return right(task); };
  EXPECT_EQ(merged(&other), alone);
  EXPECT_GE(other.asks, 6) << "three pairs, and three sessions on themselves";
}

TEST_F(SharedPairs, AServerThatComesDuringAnAttemptHelpsWithTheRestOfIt) {
  other.comes_after = 1;
  other.asked = [&](const PairTask& task) { return right(task); };
  Base base(drives(), test::waits_for_no_others(), &other);
  base.pipeline.attempt(1, base.shelf);
  EXPECT_GT(other.asks, 0);
  EXPECT_LT(other.asks, 5) << "of two pairs, and three sessions on themselves, one pair and two were searched before";
}

TEST_F(SharedPairs, WhatWaitsForItsTurnIsAnnouncedToo) {
  std::set<std::pair<SessionId, SessionId>> announced;
  Base base(drives(), test::waits_for_no_others(), &other);
  base.pipeline.attempt(1, base.shelf);
  for (const auto& [digest, task] : other.open) announced.insert(std::minmax(task.a, task.b));
  EXPECT_EQ(announced, (std::set<std::pair<SessionId, SessionId>>{{2, 3}})) << "for the attempts of the other two";
  other.open.clear();
  base.pipeline.attempt(1, base.shelf);
  EXPECT_EQ(other.open.size(), 1U) << "as long as they were not tried";
}

TEST_F(SharedPairs, WithoutAnAnswerAllIsFoundHere) {
  EXPECT_EQ(merged(&other), alone);
  EXPECT_GE(other.asks, 6);
}

TEST_F(SharedPairs, DamagedAnswersAreNotUsed) {
  other.asked = [&](const PairTask& task) {
    PairHelpers::Answer answer = right(task);
    answer.result[answer.result.size() / 2] ^= 1;
    return answer;
  };
  EXPECT_EQ(merged(&other), alone);
}

TEST_F(SharedPairs, PlacesThatAreNotInTheSessionsAreOfNoUse) {
  other.asked = [&](const PairTask& task) {
    PairFindings found = decode_findings(there.find(task.a, task.b)).value();
    for (HopefulCase& one : found.hopeful) one.place.p_b.x() += 1000;
    found.judged.clear();
    return PairHelpers::Answer{PairHelpers::Turn::done, encode_findings(found)};
  };
  Base base(drives(), test::waits_for_no_others(), &other);
  for (const SessionId id : {1, 2, 3}) base.pipeline.attempt(id, base.shelf);
  EXPECT_GT(base.pipeline.atlas().components.size(), 1U);
}

TEST_F(SharedPairs, WhileOthersAreBusyTheNextIsSearchedAhead) {
  other.gives_claims = true;
  other.asked = [](const PairTask&) { return PairHelpers::Answer{PairHelpers::Turn::others, {}}; };
  other.waited = [&](const PairTask& task) { return right(task); };
  EXPECT_EQ(merged(&other), alone);
  EXPECT_GT(other.claims, 0);
  EXPECT_GT(other.waits, 0) << "where nothing else is left";
}

TEST_F(SharedPairs, OthersThatNeverFinishAreNotWaitedForWithoutEnd) {
  other.asked = [](const PairTask&) { return PairHelpers::Answer{PairHelpers::Turn::others, {}}; };
  EXPECT_EQ(merged(&other), alone) << "wait() says that it is this server's turn";
  EXPECT_GT(other.waits, 0);
}

TEST_F(SharedPairs, ASessionThatHasGrownIsAskedForAnew) {
  const auto grown = [&](PairHelpers* helpers) {
    Drive first = drives()[0], rest = drives()[1];
    Base base({first}, test::waits_for_no_others(), helpers);
    Drive begun = rest;
    begun.keyframes.resize(20);
    begun.clouds.resize(20);
    base.arrive(begun);
    base.pipeline.attempt(2, base.shelf);
    for (std::size_t k = 20; k < rest.keyframes.size(); ++k) {
      base.pipeline.add_keyframe(2, rest.keyframes[k]);
      base.shelf.clouds[{2, k + 1}] = rest.clouds[k];
    }
    base.pipeline.complete_session(2);
    base.pipeline.attempt(2, base.shelf);
    return bytes_of(base.pipeline);
  };
  std::set<std::string> digests;
  other.asked = [&](const PairTask& task) {
    if (task.a != task.b) digests.insert(task.digest);
    return PairHelpers::Answer();
  };
  EXPECT_EQ(grown(&other), grown(nullptr));
  EXPECT_EQ(digests.size(), 2U);
}

TEST_F(SharedPairs, FindingsComeBackToTheBitAndDamageIsSeen) {
  const std::string bytes = there.find(1, 2);
  const auto back = decode_findings(bytes);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_GT(back->hypotheses.size(), 0U);
  EXPECT_GT(back->hopeful.size(), 0U);
  EXPECT_EQ(encode_findings(*back), bytes);
  const std::string itself = there.find(1, 1);
  EXPECT_EQ(encode_findings(decode_findings(itself).value()), itself);
  EXPECT_GT(decode_findings(itself)->itself.path_m, 0);
  for (std::size_t size = 0; size < bytes.size(); size += 97) EXPECT_FALSE(decode_findings(bytes.substr(0, size)));
  for (std::size_t i = 0; i < bytes.size(); i += 101) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    EXPECT_FALSE(decode_findings(damaged)) << "byte " << i;
  }
  EXPECT_FALSE(decode_findings(bytes + "x"));
}

TEST_F(SharedPairs, TheDigestIsOfAllThatTheResultDependsOn) {
  const std::string before = there.digest(1, 2);
  there.shelf.clouds.erase({1, 3});
  const std::string without_a_cloud = there.digest(1, 2);
  EXPECT_NE(without_a_cloud.substr(0, 32), before.substr(0, 32));
  EXPECT_EQ(without_a_cloud.substr(32), before.substr(32)) << "the other session is the same";
  std::vector<Drive> moved = drives();
  moved[1].keyframes[5].T_local_sensor.translation().x() += 1e-9;
  EXPECT_NE(PairSearcher(moved).digest(1, 2).substr(32), before.substr(32));
  MergeConfig finer;
  finer.placements = 900;
  EXPECT_NE(computed_by(finer), computed_by({}));
  MergeConfig more_threads;
  more_threads.threads = 7;
  EXPECT_EQ(computed_by(more_threads), computed_by({})) << "results do not depend on it";
}

}  // namespace
}  // namespace headframe
