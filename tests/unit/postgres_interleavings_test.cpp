// Two servers on one PostgreSQL: every order of their steps, with connections that end and answers that are lost in
// between. Whatever happens, they publish one sequence of revisions.
#include <gtest/gtest.h>

#include <array>

#include "server/store/postgres_writer.hpp"
#include "tests/support/both_stores.hpp"

namespace headframe {
namespace {

enum class Fault {
  none,
  cut_off,      // its connection ends before the step
  answer_lost,  // it ends when a commit is durable, and before it is answered
  lingers,      // the same, and PostgreSQL does not notice until the end of the schedule: its lock stays
};
struct Step {
  int server = 0;
  Fault fault = Fault::none;
};
using Schedule = std::vector<Step>;

constexpr int steps = 4, most_faults = 2;

/// All orders of `steps` steps of two servers, with at most so many faults.
void add_all(Schedule begun, int faults, std::vector<Schedule>& all) {
  if (begun.size() == steps) return all.push_back(begun);
  for (const int server : {0, 1})
    for (const Fault fault : {Fault::none, Fault::cut_off, Fault::answer_lost, Fault::lingers}) {
      if (fault != Fault::none && faults == 0) continue;
      begun.push_back({server, fault});
      add_all(begun, faults - static_cast<int>(fault != Fault::none), all);
      begun.pop_back();
    }
}

std::string described(const Schedule& schedule) {
  std::string out;
  for (const Step& step : schedule)
    out += std::string(step.server == 0 ? " A" : " B") +
           std::array{"", "(cut off)", "(answer lost)", "(lingers)"}.at(static_cast<std::size_t>(step.fault));
  return out;
}

/// What a server does with its store, one step at a time: it waits for the database, reads the last revision, and
/// publishes the next ones.
class Server {
 public:
  Server(std::string url, std::int64_t mark, PostgresDatabase& operator_of_postgres)
      : url_(std::move(url)), mark_(mark), postgres_(operator_of_postgres) {}

  void step(Fault fault) {
    if (refused_) return;
    if (fault == Fault::cut_off) cut_off();
    if (!writer_)
      wait_for_turn();
    else if (!writing_)
      begin();
    else
      commit(fault);
  }

  /// PostgreSQL notices what it did not.
  void notice() { lingering_.reset(); }

  bool may_write() const { return writer_ && !refused_; }
  bool refused() const { return refused_; }
  const std::vector<std::int64_t>& acknowledged() const { return acknowledged_; }

 private:
  void wait_for_turn() {
    if (!waiting_ || !waiting_->is_connected()) {
      waiting_ = std::make_unique<PostgresDatabase>(url_, "PostgreSQL");
      ASSERT_TRUE(waiting_->connect());
    }
    const auto taken = try_to_take(*waiting_);
    if (!taken || !*taken) return;
    auto writer = PostgresWriterConnection::open(std::move(waiting_), mark_);
    ASSERT_TRUE(writer) << writer.error().message;
    writer_ = std::move(*writer);
    ASSERT_TRUE(writer_->database().each("SELECT coalesce(max(revision), 0) FROM published",
                                         [&](const Row& row) { revision_ = row.integer(0); }));
  }

  void begin() {
    const auto begun = writer_->begin();
    if (!begun) return look_why(begun.error());
    if (!*begun) return acknowledge();  // the one in doubt
    writing_ = true;
    (void)writer_->database().run("INSERT INTO published (revision, server) VALUES (?, ?)", revision_ + 1, mark_);
  }

  void commit(Fault fault) {
    writing_ = false;
    const bool is_lost = fault == Fault::answer_lost || fault == Fault::lingers;
    if (is_lost && writer_->database().settle() && writer_->database().execute("COMMIT")) {
      cut_off();
      if (fault == Fault::lingers) linger();
    }
    const auto done = writer_->commit();
    if (done) return acknowledge();
    writer_->rollback();
    look_why(done.error());
  }

  void acknowledge() { acknowledged_.push_back(++revision_); }
  /// A server that may not write any more ends.
  void look_why(const Error& why) {
    if (why.code != ErrorCode::bad_input) return;
    refused_ = true;
    writer_.reset();
  }

  /// Returns when PostgreSQL has ended the connection, and with it the lock.
  void cut_off() {
    Database* own = writer_ ? &writer_->database() : waiting_.get();
    std::int64_t pid = 0;
    if (own == nullptr || !own->each("SELECT pg_backend_pid()", [&](const Row& row) { pid = row.integer(0); })) return;
    ASSERT_TRUE(postgres_.each(
        "SELECT pg_terminate_backend(?::integer, 5000)", [](const Row&) {}, pid));
  }

  void linger() {
    lingering_ = std::make_unique<PostgresDatabase>(url_, "PostgreSQL");
    ASSERT_TRUE(lingering_->connect());
    ASSERT_TRUE(try_to_take(*lingering_).value());
  }

  const std::string url_;
  const std::int64_t mark_;
  PostgresDatabase& postgres_;
  std::unique_ptr<PostgresDatabase> waiting_, lingering_;
  std::unique_ptr<PostgresWriterConnection> writer_;
  bool writing_ = false, refused_ = false;
  std::int64_t revision_ = 0;
  std::vector<std::int64_t> acknowledged_;
};

class PostgresInterleavings : public testing::Test {
 protected:
  void SetUp() override {
    if (test::PostgresCluster::programs().empty()) GTEST_SKIP() << test::PostgresCluster::not_installed;
    home.emplace(Engine::postgres);
    open(*home).reset();
    postgres = std::make_unique<PostgresDatabase>(home->url(), "PostgreSQL");
    ASSERT_TRUE(postgres->connect());
    ASSERT_TRUE(postgres->execute("CREATE TABLE published (id bigserial, revision bigint, server bigint)"));
  }

  void run(const Schedule& schedule) {
    SCOPED_TRACE(described(schedule));
    ASSERT_TRUE(postgres->execute("TRUNCATE published"));
    std::array servers{Server(home->url(), 1, *postgres), Server(home->url(), 2, *postgres)};
    while (!servers[0].may_write() && !HasFailure()) servers[0].step(Fault::none);  // once those of before have gone
    for (const Step& step : schedule) servers.at(static_cast<std::size_t>(step.server)).step(step.fault);
    for (Server& server : servers) server.notice();
    const std::size_t before = servers[0].acknowledged().size() + servers[1].acknowledged().size();
    for (int i = 0; i < 4; ++i)
      for (Server& server : servers) server.step(Fault::none);
    EXPECT_GT(servers[0].acknowledged().size() + servers[1].acknowledged().size(), before) << "one of them goes on";
    EXPECT_FALSE(servers[0].refused() && servers[1].refused());
    look_at_what_was_published(servers);
    took_over += servers[1].may_write() ? 1 : 0;
    refused += servers[0].refused() ? 1 : 0;
  }

  void look_at_what_was_published(const std::array<Server, 2>& servers) const {
    std::vector<std::int64_t> by;
    ASSERT_TRUE(postgres->each("SELECT revision, server FROM published ORDER BY id", [&](const Row& row) {
      by.push_back(row.integer(1));
      EXPECT_EQ(row.integer(0), static_cast<std::int64_t>(by.size())) << "one number, one revision";
    }));
    EXPECT_TRUE(std::is_sorted(by.begin(), by.end())) << "who was taken over publishes nothing more";
    for (const std::int64_t mark : {1, 2})
      for (const std::int64_t revision : servers.at(static_cast<std::size_t>(mark - 1)).acknowledged()) {
        ASSERT_LE(revision, static_cast<std::int64_t>(by.size())) << "what was acknowledged is there";
        EXPECT_EQ(by[static_cast<std::size_t>(revision - 1)], mark) << "and is what that server wrote";
      }
  }

  std::optional<StoreHome> home;
  std::unique_ptr<PostgresDatabase> postgres;
  int took_over = 0, refused = 0;
};

TEST_F(PostgresInterleavings, OneSequenceOfRevisionsWhateverHappens) {
  std::vector<Schedule> all;
  add_all({}, most_faults, all);
  for (const Schedule& schedule : all) {
    run(schedule);
    if (HasFailure()) break;
  }
  EXPECT_GT(took_over, 20) << "of " << all.size();
  EXPECT_GT(refused, 20) << "servers that wanted to write on";
}

}  // namespace
}  // namespace headframe
