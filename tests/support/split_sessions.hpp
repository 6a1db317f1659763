#pragma once
// A hub whose robot's odometry jumps, what its connection and the worker hear, and a store of its own.

#include <algorithm>
#include <functional>
#include <mutex>
#include <thread>

#include "server/net/session_hub.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/nobodys_news.hpp"
#include "tests/support/robot_bytes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {

using Numbers = std::vector<std::uint64_t>;

class RobotEnd : public RobotLink {
 public:
  Numbers keyframes, clouds, refused, asked, updates_of_poses;
  std::vector<v1::TransformUpdate> updates;
  bool stored = true, closed = false;
  void settled(std::size_t, const Result<void>& result) override { stored &= result.has_value(); }
  void keyframes_durable(std::uint64_t sequence) override { keyframes.push_back(sequence); }
  void poses_durable(std::uint64_t update) override { updates_of_poses.push_back(update); }
  void cloud_durable(std::uint64_t sequence) override { clouds.push_back(sequence); }
  void cloud_refused(std::uint64_t sequence, const std::string&) override { refused.push_back(sequence); }
  void request_submap(const Numbers& sequences) override { asked = sequences; }
  void update_transform(std::shared_ptr<const TransformPages> all) override {
    v1::ServerMessage message;
    ASSERT_TRUE(message.ParseFromString(all->front()));
    updates.push_back(message.transform_update());
  }
  v1::Localization localization;  // the last
  void tell_localization(std::shared_ptr<const std::string> payload) override {
    v1::ServerMessage message;
    ASSERT_TRUE(message.ParseFromString(*payload));
    localization = message.localization();
  }
  void tell_surroundings(SurroundingsKind, std::shared_ptr<const std::string>) override {}
  void stand_by() override {}
  void close(v1::ErrorKind, const std::string&, bool) override { closed = true; }
};

/// What the worker was told, in words.
class HeardNews : public NobodysNews {
 public:
  std::mutex mutex;
  std::vector<std::string> heard;
  void say(const std::string& what, SessionId session, std::uint64_t number = 0) {
    const std::lock_guard lock(mutex);
    heard.push_back(what + " " + std::to_string(session) + (number > 0 ? "/" + std::to_string(number) : ""));
  }
  void session_added(SessionId session, const NewSession& added) override {
    say("added" + (added.site.empty() ? "" : " at " + added.site), session);
  }
  void keyframes_durable(SessionId session, std::uint64_t sequence) override { say("keyframe", session, sequence); }
  void cloud_durable(const KeyframeRef& cloud) override { say("cloud", cloud.session, cloud.sequence); }
  void clouds_unavailable(SessionId session, const Numbers& sequences) override {
    for (const std::uint64_t sequence : sequences) say("no cloud", session, sequence);
  }
  void poses_durable(SessionId session) override { say("poses", session); }
  void robot_came(SessionId session, bool) override { say("came", session); }
  void robot_left(SessionId session) override { say("left", session); }
  void asks_where(SessionId session, bool asks) override { say(asks ? "asks" : "asks no more", session); }
  void trigger(SessionId session, Trigger trigger) override {
    say(trigger == Trigger::goodbye ? "ended" : "trigger", session);
  }
  bool has(const std::string& what) {
    const std::lock_guard lock(mutex);
    return std::find(heard.begin(), heard.end(), what) != heard.end();
  }
};

/// A store to which something comes in between.
class InterruptedStore : public Store {
 public:
  explicit InterruptedStore(std::unique_ptr<Store> inner) : inner_(std::move(inner)) {}
  std::function<void()> before_cloud;  // once
  void write(Write write, Done done) override {
    if (before_cloud && std::holds_alternative<PutCloud>(write)) std::exchange(before_cloud, {})();
    inner_->write(std::move(write), std::move(done));
  }
  StoreLoad load() const override { return inner_->load(); }
  bool is_away() override { return inner_->is_away(); }
  Result<std::vector<SessionRecord>> sessions() override { return inner_->sessions(); }
  Result<void> each_keyframe(SessionId session, std::uint64_t first,
                             const std::function<void(Keyframe)>& visit) override {
    return inner_->each_keyframe(session, first, visit);
  }
  Result<NewPoses> new_poses(SessionId session) override { return inner_->new_poses(session); }
  Result<std::uint64_t> last_keyframe(SessionId session) override { return inner_->last_keyframe(session); }
  Result<Numbers> cloud_sequences(SessionId session) override { return inner_->cloud_sequences(session); }
  Result<std::vector<CloudSize>> cloud_sizes(SessionId session) override { return inner_->cloud_sizes(session); }
  Result<Numbers> let_go(SessionId session) override { return inner_->let_go(session); }
  Result<std::optional<std::uint64_t>> free_bytes() override { return inner_->free_bytes(); }
  Result<std::string> cloud(const KeyframeRef& keyframe) override { return inner_->cloud(keyframe); }
  Result<StoredMerge> merge() override { return inner_->merge(); }
  Result<StoredNotes> notes() override { return inner_->notes(); }
  Result<std::vector<RobotRecord>> robots() override { return inner_->robots(); }
  Result<std::map<std::string, std::string>> robot_sites() override { return inner_->robot_sites(); }
  Result<std::vector<TroubleRecord>> troubles() override { return inner_->troubles(); }
  Result<std::filesystem::path> backup() override { return inner_->backup(); }

 private:
  std::unique_ptr<Store> inner_;
};

class HubParts : public testing::Test {
 protected:
  void SetUp() override { start(); }
  void TearDown() override { store_.reset(); }  // its callbacks find the hub

  void start() {
    store_.reset();
    hub_.reset();
    auto store = std::make_unique<InterruptedStore>(open(dir_));
    interrupted_ = store.get();
    store_ = std::move(store);
    hub_ = std::make_unique<SessionHub>(*store_, news_);
    ASSERT_TRUE(hub_->restore());
    come();
  }
  Hello hello(std::uint64_t run = 10) const {
    Hello h = robot_hello();
    h.spool_runs = {run};
    return h;
  }
  void come() {
    link_ = std::make_shared<RobotEnd>();
    const auto admitted = hub_->admit(hello(), link_);
    ASSERT_TRUE(admitted) << admitted.error().message;
    id_ = admitted->session;
    durable_ = admitted->durable;
    settle();
  }
  void settle() const {
    while (hub_->unsettled() > 0) std::this_thread::yield();
  }
  void keyframes(std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t i = first; i <= last; ++i) hub_->take(id_, KeyframeReceived{line_keyframe(i)}, link_);
    settle();
  }
  void cloud(std::uint64_t sequence) {
    hub_->take(id_, CloudReceived{sequence, "cloud " + std::to_string(sequence)}, link_);
    settle();
  }
  void cut(SessionId session, std::uint64_t from, bool for_good = true) {
    hub_->tell_cut(session, {from, for_good, "its odometry jumps 400 m"});
    settle();
  }
  SessionRow row(SessionId session) const {
    for (const SessionRow& row : hub_->sessions())
      if (row.id == session) return row;
    return {};
  }
  /// The robot's numbers of what a session has, by where its keyframes lie.
  Numbers stored(SessionId session) const {
    Numbers out;
    for (const Keyframe& k : headframe::keyframes(*store_, session))
      out.push_back(static_cast<std::uint64_t>(std::llround(k.T_local_sensor.translation().x())));
    return out;
  }

  TempDir dir_;
  HeardNews news_;
  std::unique_ptr<Store> store_;
  InterruptedStore* interrupted_ = nullptr;  // the same
  std::unique_ptr<SessionHub> hub_;
  std::shared_ptr<RobotEnd> link_;
  SessionId id_ = 0;
  Durable durable_;
};

}  // namespace headframe
