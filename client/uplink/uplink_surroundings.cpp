// Questions about what others know, on whichever connection carries the session.
#include <boost/asio/post.hpp>

#include "client/uplink/uplink_thread.hpp"

namespace headframe {
namespace {

const std::string too_old = "this base station is older than the question";

template <class Answer>
Answer unsupported() {
  Answer answer;
  answer.state = SurroundingsTold::State::unsupported;
  answer.missing = too_old;
  return answer;
}

}  // namespace

/// Sends all open questions on a connection that now carries the session.
void Uplink::Thread::ask_around(const Link& l) {
  bool knows = true;
  for (const v1::RobotMessage& question : book.questions()) knows = l->protocol.ask_around(question);
  if (knows) return;
  if (book.wants_trajectories()) on_event(unsupported<Trajectories>());
  if (book.wants_coverage()) on_event(unsupported<Coverage>());
  if (!book.wants_map()) return;
  book.give_up_map();
  MapAround map;
  map.refused = too_old;
  on_event(map);
}

void Uplink::Thread::take(const Link& l, const SurroundingsMessage& told) {
  auto taken = book.take(*told.message);
  if (!taken) {
    end(l, Again::later);
    return on_event(LinkEnded{{ErrorCode::bad_input, "from the server: " + taken.error().message}, false});
  }
  if (taken->next) (void)l->protocol.ask_around(*taken->next);
  if (auto* trajectories = std::get_if<Trajectories>(&taken->told)) on_event(std::move(*trajectories));
  if (auto* coverage = std::get_if<Coverage>(&taken->told)) on_event(std::move(*coverage));
  if (auto* map = std::get_if<MapAround>(&taken->told)) on_event(std::move(*map));
}

/// `change` returns the question to send now, if any.
template <class Change>
void Uplink::Thread::change_questions(Change change) {
  const auto asked = change(book);
  if (!asked || !carried() || !link->protocol.welcomed()) return;
  if (!link->protocol.ask_around(*asked)) ask_around(link);
  pump(link);
}

void Uplink::trajectories(bool asks) {
  boost::asio::post(thread_->io, [t = thread_.get(), asks] {
    t->change_questions([asks](SurroundingsBook& book) -> std::optional<v1::RobotMessage> {
      if (book.wants_trajectories() == asks) return std::nullopt;
      book.want_trajectories(asks);
      return book.trajectories_question();
    });
  });
}

void Uplink::coverage(bool asks) {
  boost::asio::post(thread_->io, [t = thread_.get(), asks] {
    t->change_questions([asks](SurroundingsBook& book) -> std::optional<v1::RobotMessage> {
      if (book.wants_coverage() == asks) return std::nullopt;
      book.want_coverage(asks);
      return book.coverage_question();
    });
  });
}

void Uplink::map_around(const MapQuestion& question) {
  boost::asio::post(thread_->io, [t = thread_.get(), question] {
    t->change_questions([&question](SurroundingsBook& book) -> std::optional<v1::RobotMessage> {
      book.want_map(question);
      return book.map_question();
    });
  });
}

}  // namespace headframe
